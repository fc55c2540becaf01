#include "pore_solver/output/probes.hpp"

#include "common/geometry/pieces.hpp"
#include "common/geometry/shapes.hpp"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>

namespace poretwin::pore {
namespace {

/// Weights of the three corners of a triangle at x, whose sum is 1; empty where the triangle is flat.
std::optional<std::array<double, 3>> weights(const Point3& a, const Point3& b, const Point3& c, const Point3& x) {
  const double area = cross(b - a, c - a);
  if (std::abs(area) < 1e-9 * (b - a).norm() * (c - a).norm()) return std::nullopt;
  const double at_b = cross(x - a, c - a) / area, at_c = cross(b - a, x - a) / area;
  return std::array{1.0 - at_b - at_c, at_b, at_c};
}

}  // namespace

Probes::Probes(const Case& scene, const Network& network)
    : scene_(scene), network_(network), neighbours_(network.size()) {
  for (const auto& link : network.links) {
    if (network.soil[link.a] != network.soil[link.b] || !link.shift.isZero(0.0)) continue;
    neighbours_[link.a].push_back(link.b);
    neighbours_[link.b].push_back(link.a);
  }
  for (std::size_t a = 0; a < network.size(); ++a) {
    const auto angle = [&](Index b) {
      const Point3 way = network.position[b] - network.position[a];
      return std::atan2(way.y(), way.x());
    };
    std::sort(neighbours_[a].begin(), neighbours_[a].end(), [&](Index b, Index c) { return angle(b) < angle(c); });
  }
}

Index Probes::nearest(const Point3& x, std::optional<std::size_t> soil) const {
  std::size_t found = 0;
  double least = HUGE_VAL;
  for (std::size_t a = 0; a < network_.size(); ++a)
    if (const double d = (network_.position[a] - x).squaredNorm(); d < least && (!soil || network_.soil[a] == *soil)) {
      least = d;
      found = a;
    }
  return static_cast<Index>(found);
}

std::optional<Probe> Probes::at(const Point3& x) const {
  // A place on the border of two soils belongs to the soil of the nearest point. Without this shift, rounding would
  // decide.
  const Point3 inside = x + 1e-6 * (network_.position[nearest(x, std::nullopt)] - x);
  const Soil* soil = soil_at(scene_, inside);
  if (!soil) return std::nullopt;
  const Index a = nearest(x, static_cast<std::size_t>(soil - scene_.soils.data()));
  if (scene_.general.dimension == 3) return in_space(x, a);
  const auto& around = neighbours_[a];
  Probe best{{a, a, a, a}, {1.0, 0.0, 0.0, 0.0}};
  // Takes the triangle that contains x, or else the triangle whose least weight at x is largest.
  double most = -HUGE_VAL;
  for (std::size_t i = 0; i < around.size(); ++i) {
    const Index b = around[i], c = around[(i + 1) % around.size()];
    const auto w = weights(network_.position[a], network_.position[b], network_.position[c], x);
    if (!w) continue;
    const double least = *std::min_element(w->begin(), w->end());
    if (least <= most) continue;
    most = least;
    best = {{a, b, c, a}, {(*w)[0], (*w)[1], (*w)[2], 0.0}};
  }
  if (most > -HUGE_VAL || around.empty()) return best;
  // With a single row of points the value is interpolated along the row.
  for (const Index b : around) {
    const Point3 way = network_.position[b] - network_.position[a];
    const double along = way.dot(x - network_.position[a]) / way.squaredNorm();
    if (along < most && most > 0.0) continue;
    most = along;
    best = {{a, b, a, a}, {1.0 - along, along, 0.0, 0.0}};
  }
  return best;
}

Probe Probes::in_space(const Point3& x, Index a) const {
  const Point3 at = network_.position[a];
  const auto& around = neighbours_[a];
  Probe best{{a, a, a, a}, {1.0, 0.0, 0.0, 0.0}};
  double most = -HUGE_VAL;
  // Weights of the k given neighbours, by a least-squares fit of x - at in the space that they span. Neighbours that
  // span fewer than k dimensions do not count.
  const auto try_with = [&](std::size_t k, const std::array<Index, 3>& corner) {
    Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> ways(3, static_cast<Eigen::Index>(k));
    for (std::size_t i = 0; i < k; ++i)
      ways.col(static_cast<Eigen::Index>(i)) = (network_.position[corner[i]] - at) / scene_.fluid.particle_spacing;
    const auto qr = ways.colPivHouseholderQr();
    constexpr double flat = 1e-6;
    if (std::abs(qr.matrixR()(static_cast<Eigen::Index>(k) - 1, static_cast<Eigen::Index>(k) - 1)) < flat) return;
    const Eigen::VectorXd w = qr.solve((x - at) / scene_.fluid.particle_spacing);
    const double least = std::min(w.minCoeff(), 1.0 - w.sum());
    if (least <= most) return;
    most = least;
    best.weight = {1.0 - w.sum(), 0.0, 0.0, 0.0};
    for (std::size_t i = 0; i < k; ++i) {
      best.point[i + 1] = corner[i];
      best.weight[i + 1] = w[static_cast<Eigen::Index>(i)];
    }
  };
  const std::size_t n = around.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j)
      for (std::size_t k = j + 1; k < n; ++k) try_with(3, {around[i], around[j], around[k]});
  if (most == -HUGE_VAL)
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j) try_with(2, {around[i], around[j], a});
  if (most == -HUGE_VAL)
    for (const Index b : around) try_with(1, {b, a, a});
  return best;
}

ProbeLine Probes::along(const Point3& from, const Point3& to) const {
  ProbeLine line;
  line.length = (to - from).norm();
  const int parts = std::max(1, static_cast<int>(std::ceil(line.length / (0.25 * scene_.fluid.particle_spacing))));
  line.step = line.length / parts;
  for (int i = 0; i <= parts; ++i) {
    const Point3 x = from + (to - from) * i / parts;
    if (const auto probe = at(x)) {
      line.place.push_back(line.length * i / parts);
      line.probe.push_back(*probe);
    }
  }
  return line;
}

}  // namespace poretwin::pore
