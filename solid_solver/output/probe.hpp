// Values at arbitrary points: first-order moving least squares, exact for linear fields up to the soil's surface and
// base.
#pragma once

#include "common/numerics/dense.hpp"
#include "solid_solver/numerics/points.hpp"
#include "solid_solver/numerics/readings.hpp"
#include "solid_solver/setup.hpp"

#include <functional>
#include <limits>

namespace poretwin::solid {

/// The images from which a quantity may be read.
enum class Reach {
  material,  ///< periodic images only: stresses, pressures and fractions have a kink at a mirror plane
  motion,    ///< all images but those of frictional walls and of plates: velocities are reversed at fixed walls and
             ///< mirrored at rollers
};

/// Interpolated value at x [m] of value(particle, velocity map of the image); NaN outside the soil.
template <int D>
double probe(const Setup<D>& setup, const State<D>& state, const Vec<D>& x, Reach reach,
             const std::function<double(std::size_t, const Mat<D>&)>& value) {
  using Basis = Eigen::Matrix<double, D + 1, 1>;
  const double h = setup.smoothing_length;
  const std::size_t n = state.particles.size();
  Eigen::Matrix<double, D + 1, D + 1> moment = Eigen::Matrix<double, D + 1, D + 1>::Zero();
  Basis right = Basis::Zero();
  double cover = 0.0;
  const sph::Sight<D>& sight = setup.boundaries.sight;
  typename sph::Sight<D>::Near walls;
  sight.find_near(x, sph::support_radius * h, walls);
  for (std::size_t j = 0; j < n + state.near.images.size(); ++j) {
    const auto* rule = j < n ? nullptr : &state.near.images[j - n];
    const std::size_t parent = rule ? rule->parent : j;
    const Vec<D> position =
        rule ? Vec<D>(rule->map * state.particles.position[parent] + rule->shift) : state.particles.position[parent];
    const Vec<D> r = position - x;
    const double weight = state.particles.volume[parent] * sph::WendlandC2<D>::value(r.norm(), h);
    if (weight <= 0.0) continue;
    // Past thin walls only particles themselves are read, where no wall hides them.
    if (!walls.empty() && (rule || !sight.open(x, position, walls))) continue;
    cover += weight;
    if (rule && (reach == Reach::material || rule->slips || rule->moves) && !rule->periodic) continue;
    Basis basis;
    basis << 1.0, r / h;
    moment += weight * basis * basis.transpose();
    right += weight * value(parent, rule ? rule->velocity : Mat<D>(Mat<D>::Identity())) * basis;
  }
  if (cover < points::outside || moment(0, 0) <= 0.0) return std::numeric_limits<double>::quiet_NaN();
  const Eigen::Matrix<double, D + 1, D + 1> scaled = moment / moment(0, 0);
  if (scaled.determinant() < readings::least_determinant)
    return right[0] / moment(0, 0);  // too few neighbours for a slope
  const Basis solution = solve_symmetric<D + 1>(moment, right);
  return solution[0];
}

}  // namespace poretwin::solid
