// The water as a set of points with fields: particles, buffers behind faces and images behind walls. Fields are
// interpolated between these points.
#pragma once

#include "common/geometry/surfaces.hpp"
#include "common/numerics/dense.hpp"
#include "common/particles/neighbours.hpp"
#include "common/particles/sight.hpp"
#include "fluid_solver/boundary/walls.hpp"
#include "fluid_solver/discretisation/stencil.hpp"
#include "fluid_solver/state.hpp"

#include <limits>

namespace poretwin::fluid {

template <int D>
struct Cloud {
  std::size_t n_real = 0;
  VecArray<D> position;
  ScalarArray volume, length;
  ScalarArray owner;     ///< the particle to which an image belongs; -1: a buffer, or its image
  ScalarArray pressure;  ///< total, Pa
  VecArray<D> velocity;
  OrZero<Vec<D>> solid_velocity, solid_change, surface_gradient;
  OrZero<double> surface_share, spreading;
  ScalarArray mask, void_fraction;
  sph::Sight<D> sight;          ///< lines of sight past the walls
  std::vector<Index> column;    ///< [buffers, which follow the particles] the face column of each buffer
  std::size_t n_base = 0;       ///< number of points that are not images
  std::vector<Index> by, of;    ///< [images] see sph::Images; only where lines of sight are limited
  std::vector<Index> original;  ///< [images] the point whose image it is
  bool shaped_walls = false;    ///< images lie behind walls of any shape (3D)
  /// [images] 1: behind a wall at which the pressure has a slope, as in soil in beds. Such an image has no pressure.
  /// Empty: all images have the pressure of their originals.
  std::vector<char> without_pressure;
  [[nodiscard]] std::size_t size() const { return position.size(); }
  [[nodiscard]] bool has_pressure(Index j) const {
    return j < n_base || without_pressure.empty() || without_pressure[j - n_base] == 0;
  }
};

/// A point of the still water behind a face of prescribed head. The point stands for a bulk volume of this water, which
/// no particle represents.
template <int D>
struct StillWater {
  Vec<D> position;
  double volume = 0.0, pressure = 0.0;  ///< m^D; piezometric, Pa
};

/// The cloud of the present state. sticky: walls at which water does not slip, one bit for each wall. slope_at_walls:
/// the pressure has a slope at walls.
template <int D>
Cloud<D> make_cloud(const State<D>& state, const Walls<D>& walls, const Vec<D>& weight, const Vec<D>& origin,
                    std::span<const StillWater<D>> reservoir = {}, std::uint32_t sticky = 0,
                    bool slope_at_walls = false) {
  const auto& p = state.particles;
  Cloud<D> c;
  c.n_real = p.size();
  c.position = p.position;
  c.volume = p.volume;
  c.pressure = p.pressure;
  c.velocity = p.velocity;
  c.solid_velocity = p.solid_velocity;
  c.solid_change = p.solid_change;
  c.surface_gradient = p.surface_gradient;
  c.surface_share = p.surface_share;
  c.spreading = p.spreading;
  c.mask = p.mask;
  c.void_fraction = p.void_fraction;
  VecArray<D> owners = p.position;  // of images
  for (const auto& b : make_buffers(state.columns)) {
    const auto& column = state.columns[b.column];
    c.column.push_back(b.column);
    c.position.push_back(b.position);
    owners.push_back(b.foot);
    c.volume.push_back(b.volume);
    c.pressure.push_back(column.pressure - column.slope * b.outside);
    c.velocity.push_back(column.speed * column.normal);
    for (auto* v : {&c.solid_velocity, &c.solid_change, &c.surface_gradient}) v->grow();
    c.surface_share.grow();
    c.spreading.grow();
    c.mask.push_back(0.0);
    c.void_fraction.push_back(column.void_fraction);
  }
  for (const auto& w : reservoir) {
    c.position.push_back(w.position);
    owners.push_back(w.position);
    c.volume.push_back(w.volume);
    c.pressure.push_back(w.pressure);
    c.velocity.push_back(Vec<D>::Zero());
    for (auto* v : {&c.solid_velocity, &c.solid_change, &c.surface_gradient}) v->grow();
    c.surface_share.grow();
    c.spreading.grow();
    c.mask.push_back(0.0);
    c.void_fraction.push_back(1.0);
  }
  double largest = 0.0;
  for (const double v : c.volume) {
    c.length.push_back(points::smoothing_ratio * spacing_of<D>(v));
    largest = std::max(largest, c.length.back());
  }
  for (std::size_t i = 0; i < c.size(); ++i) c.owner.push_back(i < c.n_real ? static_cast<double>(i) : -1.0);
  const VecArray<D> base = c.position;
  const double reach = sph::support_radius * largest;
  auto images = images_of<D>(base, walls.planes, walls.sight, walls.surfaces.get(), reach, owners);
  c.sight = walls.sight;
  c.n_base = base.size();
  c.original = images.parent;
  c.shaped_walls = walls.surfaces != nullptr;
  c.by = std::move(images.by);
  c.of = std::move(images.of);
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Index q = images.parent[i];
    if (slope_at_walls) c.without_pressure.push_back(images.map[i].isIdentity() ? 0 : 1);
    c.position.push_back(images.position[i]);
    c.volume.push_back(c.volume[q]);
    c.length.push_back(c.length[q]);
    c.owner.push_back(c.owner[q]);
    c.pressure.push_back(c.pressure[q]);
    const bool sticks = (images.boundaries[i] & sticky) != 0;
    c.velocity.push_back(sticks ? Vec<D>(-c.velocity[q]) : Vec<D>(images.map[i] * c.velocity[q] + images.carried[i]));
    for (auto* v : {&c.solid_velocity, &c.solid_change, &c.surface_gradient})
      if (v->is_allocated()) v->values().push_back(images.map[i] * (*v)[q]);
    if (c.spreading.is_allocated()) c.spreading.values().push_back(c.spreading[q]);
    if (c.surface_share.is_allocated()) c.surface_share.values().push_back(c.surface_share[q]);
    c.mask.push_back(c.mask[q]);
    c.void_fraction.push_back(c.void_fraction[q]);
  }
  for (std::size_t i = 0; i < c.size(); ++i) c.pressure[i] += weight.dot(c.position[i] - origin);
  return c;
}

/// Interpolation between the points of the water, at any place. width: width of the kernel, in smoothing lengths.
template <int D>
class Probe {
 public:
  explicit Probe(const Cloud<D>& cloud, double width = 1.0) : cloud_(cloud), width_(width) {
    double largest = 1e-300;
    for (const double h : cloud.length) largest = std::max(largest, h);
    reach_ = sph::support_radius * width * largest;
    grid_.build(cloud.position, reach_);
  }
  Probe(const Probe&) = delete;
  Probe& operator=(const Probe&) = delete;

  /// Value and gradient [1/m] of a field at a place. f(j) gives the field at point j of the cloud.
  struct Fit {
    double value = std::numeric_limits<double>::quiet_NaN();
    Vec<D> gradient = Vec<D>::Zero();
  };

  /// Sum of V W at x, over the sum of a lattice: 1 in the water, 0 outside.
  [[nodiscard]] double fullness(const Vec<D>& x) const {
    double sum = 0.0;
    near(x, [&](Index j, double r) { sum += cloud_.volume[j] * Kernel<D>::value(r, length(j)); });
    return sum / lattice_fullness<D>();
  }

  /// Moving least squares of first order over the points j for which counts(j) holds, or over all points where no such
  /// point is near. The result is a weighted mean where the points do not span space, and NaN outside the water.
  template <class Field, class Counts>
  [[nodiscard]] Fit fit(const Vec<D>& x, Field&& f, Counts&& counts) const {
    using Row = Eigen::Matrix<double, D + 1, 1>;
    Eigen::Matrix<double, D + 1, D + 1> moment = Eigen::Matrix<double, D + 1, D + 1>::Zero();
    Row rhs = Row::Zero();
    double scale = 0.0, sampled = 0.0;
    near(x, [&](Index j, double r) {
      const double w = cloud_.volume[j] * Kernel<D>::value(r, length(j));
      sampled += w;
      if (!counts(j)) return;
      Row row;
      row[0] = 1.0;
      row.template tail<D>() = (cloud_.position[j] - x) / reach_;
      moment += w * row * row.transpose();
      rhs += w * f(j) * row;
      scale += w * length(j);
    });
    if (sampled < points::least_sampled) return {};
    if constexpr (!std::is_same_v<std::decay_t<Counts>, All>)
      if (!(moment(0, 0) > 0.0)) return fit(x, f);
    scale /= moment(0, 0);
    // In a direction in which the points do not spread, no slope can be fitted.
    Row unit = Row::Constant(reach_ / scale);
    unit[0] = 1.0;
    const Eigen::Matrix<double, D + 1, D + 1> scaled = unit.asDiagonal() * moment * unit.asDiagonal();
    if (!all_eigenvalues_above<D + 1>(scaled, points::least_slope_moment * moment(0, 0)))
      return {rhs[0] / moment(0, 0), Vec<D>::Zero()};
    const Row solution = solve_symmetric<D + 1>(moment, rhs);
    return {solution[0], solution.template tail<D>() / reach_};
  }
  template <class Field>
  [[nodiscard]] Fit fit(const Vec<D>& x, Field&& f) const {
    return fit(x, f, All{});
  }
  template <class Field>
  [[nodiscard]] double at(const Vec<D>& x, Field&& f) const {
    return fit(x, f).value;
  }
  /// Value and gradient of the total pressure [Pa] at x.
  [[nodiscard]] Fit pressure(const Vec<D>& x) const {
    const auto at = [this](Index j) { return cloud_.pressure[j]; };
    if (cloud_.without_pressure.empty()) return fit(x, at);
    return fit(x, at, [this](Index j) { return cloud_.has_pressure(j); });
  }

 private:
  struct All {
    bool operator()(Index) const { return true; }
  };
  [[nodiscard]] double length(Index j) const { return width_ * cloud_.length[j]; }
  template <class F>
  void near(const Vec<D>& x, F&& f) const {
    typename sph::Sight<D>::Near walls;
    if (cloud_.sight.limited()) cloud_.sight.find_near(x, reach_, walls);
    grid_.for_each_within(x, reach_, [&](Index j, double r2) {
      const double support = sph::support_radius * length(j);
      if (r2 < support * support && seen(x, j, walls)) f(j, std::sqrt(r2));
    });
  }

  [[nodiscard]] bool seen(const Vec<D>& x, Index j, const typename sph::Sight<D>::Near& walls) const {
    const auto& c = cloud_;
    if constexpr (D == 3)
      if (c.shaped_walls) return j < c.n_base || Surfaces::sees(x, c.position[c.original[j - c.n_base]], c.position[j]);
    if (!c.sight.limited()) return true;
    return j < c.n_base ? c.sight.open(x, c.position[j], walls)
                        : c.sight.sees(x, j, c.n_base, c.position, c.by, c.of, walls);
  }

  const Cloud<D>& cloud_;
  double width_ = 1.0, reach_ = 0.0;
  sph::CellGrid<D> grid_;
};

}  // namespace poretwin::fluid
