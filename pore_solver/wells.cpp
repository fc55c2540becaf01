#include "pore_solver/wells.hpp"

#include "common/core/error.hpp"
#include "common/geometry/shapes.hpp"
#include "common/numerics/csr.hpp"
#include "pore_solver/numerics/wells.hpp"

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace poretwin::pore {
namespace {

constexpr double pi = std::numbers::pi;

/// The line of a well's screen.
class Axis {
 public:
  Axis(const Case& scene, const Well& well) : plane_(scene.general.dimension == 2) {
    from_ = well.points.front();
    direction_ = plane_ ? Point3::UnitZ() : Point3((well.points.back() - from_).normalized());
    length_ = plane_ ? 1.0 : (well.points.back() - from_).norm();
    // A screen along the border of cells would lie in several cells; shifted by this distance it lies in one.
    constexpr double aside = 1e-6;  // spacings
    const double dx = scene.fluid.particle_spacing;
    from_ += aside * dx * (plane_ ? Point3(1.0, 0.7, 0.0) : Point3(1.0, 0.7, 0.4));
    if (plane_) return;
    first_ = -soil_beyond(scene, 0.0, -1.0);
    last_ = length_ + soil_beyond(scene, length_, 1.0);
  }
  [[nodiscard]] bool plane() const { return plane_; }
  [[nodiscard]] double length() const { return length_; }  ///< m; 1 in 2D
  /// The part of the axis in soil around the screen [m], as far as a patch extends.
  [[nodiscard]] double first() const { return first_; }
  [[nodiscard]] double last() const { return last_; }
  [[nodiscard]] Point3 at(double along) const { return from_ + along * direction_; }
  [[nodiscard]] double along(const Point3& x) const { return plane_ ? 0.0 : direction_.dot(x - from_); }
  /// Distance from the axis, also from its continuation beyond its ends.
  [[nodiscard]] double distance(const Point3& x) const { return (x - at(along(x))).norm(); }

  /// The part of the axis from `from` to `to` [m] that is nearer to point a than to its neighbours; empty if from > to.
  [[nodiscard]] std::pair<double, double> in_cell(const Network& net, Index a, const std::vector<Index>& neighbours,
                                                  double from, double to) const {
    for (const Index b : neighbours) {
      const Point3 way = net.position[b] - net.position[a];
      const double here = way.dot(0.5 * (net.position[a] + net.position[b]) - from_), slope = way.dot(direction_);
      // Points of the axis with slope * s <= here are nearer to a.
      if (plane_ || std::abs(slope) < 1e-12 * way.norm()) {
        if (here < 0.0) return {1.0, 0.0};
      } else if (slope > 0.0) {
        to = std::min(to, here / slope);
      } else {
        from = std::max(from, here / slope);
      }
    }
    return {from, to};
  }

 private:
  /// How far soil extends from a place of the axis in a direction [m], at most as far as a patch extends.
  [[nodiscard]] double soil_beyond(const Case& scene, double along, double direction) const {
    const double dx = scene.fluid.particle_spacing, most = (wells::patch_beyond + 2.0) * dx;
    const auto in_soil = [&](double way) { return soil_at(scene, at(along + direction * way)) != nullptr; };
    constexpr double step = 0.25;  // spacings
    double in = 0.0, out = step * dx;
    while (in < most && in_soil(out)) {
      in = out;
      out += step * dx;
    }
    if (in >= most) return in;
    constexpr double sharp = 1e-9;
    while (out - in > sharp * dx) (in_soil(0.5 * (in + out)) ? in : out) = 0.5 * (in + out);
    return in;
  }

  bool plane_;
  Point3 from_, direction_;
  double length_ = 0.0, first_ = 0.0, last_ = 1.0;
};

/// Computes the logarithm of the equivalent radius at each point pierced by the well, on a patch of the network.
class Patch {
 public:
  Patch(const Case& scene, const Network& net, const Axis& axis) : net_(net), axis_(axis) {
    const double dx = scene.fluid.particle_spacing;
    const double beyond = wells::patch_beyond * dx;
    for (Index a = 0; a < net.size(); ++a) {
      const double s = axis.along(net.position[a]);
      if (!axis.plane() && (s < -beyond || s > axis.length() + beyond)) continue;
      if (axis.distance(net.position[a]) < (wells::patch_radius + 1.0) * dx) row_.emplace(a, 0);
    }
    Index n = 0;
    for (auto& [a, row] : row_)
      if (axis.distance(net.position[a]) < wells::patch_radius * dx) {
        row = n++;
        point_.push_back(a);
      } else {
        row = prescribed;
      }
    neighbours_.resize(n);
    for (const auto& link : net.links) {
      if (!link.shift.isZero(0.0)) continue;  // wells stand away from the sides
      for (const auto& [a, b] : {std::pair{link.a, link.b}, {link.b, link.a}}) {
        const auto found = row_.find(a);
        if (found == row_.end() || found->second == prescribed) continue;
        neighbours_[found->second].push_back({b, link.of_a * link.transmissibility});
      }
    }
  }

  std::vector<Pierced> pierced() {
    const auto n = point_.size();
    std::vector<Pierced> found;
    ScalarArray right(n, 0.0), diagonal(n, 0.0);
    std::vector<std::pair<Index, Index>> entries;
    for (std::size_t i = 0; i < n; ++i) {
      std::vector<Index> around;
      for (const auto& [b, t] : neighbours_[i]) {
        around.push_back(b);
        const auto other = row_.find(b);
        if (other == row_.end()) continue;  // beyond the patch's end: no flow along the axis
        diagonal[i] += t;
        if (other->second == prescribed) right[i] += t * std::log(axis_.distance(net_.position[b]));
      }
      // The reference flow goes to the whole axis, also beyond the screen, and is uniform along it.
      const auto [low, high] = axis_.in_cell(net_, point_[i], around, axis_.first(), axis_.last());
      if (!(high > low)) continue;
      right[i] -= 2.0 * pi * (high - low);
      const double from = std::max(low, 0.0), to = std::min(high, axis_.length());
      constexpr double least = 1e-6;
      if (to - from > least * axis_.length()) found.push_back({point_[i], from, to, static_cast<double>(i)});
    }
    ScalarArray u(n, 0.0);
    constexpr double tolerance = 1e-10;
    const Domain domain;  // one process has the whole field
    conjugate_gradients(
        domain,
        [&](auto x, auto y) {
          for (std::size_t i = 0; i < n; ++i) {
            y[i] = diagonal[i] * x[i];
            for (const auto& [b, t] : neighbours_[i])
              if (const auto other = row_.find(b); other != row_.end() && other->second != prescribed)
                y[i] -= t * x[other->second];
          }
        },
        [&](auto r, auto z) {
          for (std::size_t i = 0; i < n; ++i) z[i] = r[i] / diagonal[i];
        },
        right, u, tolerance * domain.norm(right), static_cast<int>(10 + 2 * n));
    for (auto& p : found) p.equivalent_radius = std::exp(u[static_cast<std::size_t>(p.equivalent_radius)]);
    std::sort(found.begin(), found.end(), [](const Pierced& p, const Pierced& q) { return p.from < q.from; });
    return found;
  }

 private:
  static constexpr Index prescribed = static_cast<Index>(-1);
  const Network& net_;
  const Axis& axis_;
  std::map<Index, Index> row_;  ///< row of each point of the patch, or `prescribed`
  std::vector<Index> point_;    ///< point of each row
  std::vector<std::vector<std::pair<Index, double>>> neighbours_;
};

}  // namespace

std::vector<Pierced> pierced_by(const Case& scene, const Network& network, const Well& well) {
  const Axis axis(scene, well);
  return Patch(scene, network, axis).pierced();
}

void add_wells(const Case& scene, Network& network) {
  const Point3 up = -scene.general.gravity.normalized();
  for (std::size_t w = 0; w < scene.wells.size(); ++w) {
    const Well& well = scene.wells[w];
    const auto pierced = pierced_by(scene, network, well);
    if (pierced.empty())
      throw CaseError(
          fmt::format("{}: well[{}]: its screen pierces no cell of the soil's points", scene.path.string(), w));
    const bool plane = scene.general.dimension == 2;
    const Point3 direction = plane ? Point3::Zero() : Point3((well.points.back() - well.points.front()).normalized());
    for (const auto& p : pierced) {
      if (!(p.equivalent_radius > well.radius))
        throw CaseError(
            fmt::format("{}: well[{}]: its radius of {} m is larger than the equivalent radius of a cell, {:.4g} "
                        "m; expected a narrower well or a larger fluid.particle_spacing",
                        scene.path.string(), w, well.radius, p.equivalent_radius));
      const Point3 a = well.points.front() + p.from * direction, b = well.points.front() + p.to * direction;
      // A screen that is not upright extends up and down around its circumference, too.
      const double aside = well.radius * std::sqrt(std::max(0.0, 1.0 - std::pow(up.dot(direction), 2)));
      Segment s;
      s.point = p.point;
      s.well = w;
      s.area = 2.0 * pi * well.radius * (p.to - p.from);
      s.transmissibility = 2.0 * pi * (p.to - p.from) / std::log(p.equivalent_radius / well.radius);
      s.centre = 0.5 * (a + b);
      s.low = std::min(up.dot(a), up.dot(b)) - aside;
      s.high = std::max(up.dot(a), up.dot(b)) + aside;
      network.segments.push_back(s);
    }
  }
  std::stable_sort(network.segments.begin(), network.segments.end(),
                   [](const Segment& x, const Segment& y) { return x.point < y.point; });
}

}  // namespace poretwin::pore
