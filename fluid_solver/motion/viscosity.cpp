#include "fluid_solver/motion/viscosity.hpp"

#include "fluid_solver/discretisation/operators.hpp"
#include "fluid_solver/numerics/motion.hpp"
#include "fluid_solver/regimes.hpp"

#include <cmath>

namespace poretwin::fluid {

template <int D>
double viscosity(const Setup<D>& setup, double wave_speed) {
  const double share = setup.is_projection() ? motion::shear_viscosity : motion::sweep_viscosity;
  return std::max(setup.kinematic_viscosity, share * setup.spacing * wave_speed);
}

/// Three viscosities act on water outside soil. (1) The water's own, Eq. (76) as corrected, with pairs amplified as for
/// the pressure, so that quadratics are exact on average. (2) A von Neumann-Richtmyer term between approaching
/// particles, for impacts; it is of third order where the flow is smooth. (3) One against noise of single particles,
/// which acts on the part of the velocity that is not linear around a particle. All are antisymmetric in pairs of
/// particles on which they act.
///
/// Numerical viscosity does not act between free water and the water of tight, moving soil, whose relative motion is no
/// noise. Drag fixes this water to the soil, so that the opposite impulse would be lost.
template <int D>
VecArray<D> forced_velocity(const Setup<D>& setup, const State<D>& state, const Stencil<D>& s, const SoilView<D>& view,
                            std::span<const Mat<D>> velocity_gradient, double interval) {
  const auto& v = state.particles.velocity;
  VecArray<D> result;
  if (!setup.periodic_gravity.isZero(0.0)) {
    result = v;
    parallel_for(result.size(), [&](std::size_t a) { result[a] += interval * setup.periodic_gravity; });
  }
  // In soil, drag damps more than this viscosity would, except where inertia dominates.
  std::vector<char> damped(s.n_real);
  parallel_for(s.n_real, [&](std::size_t a) { damped[a] = is_drag_dominated<D>(setup, state.particles, view, a); });
  if (s.domain.all_of(s.n_real, [&](std::size_t a) { return damped[a]; })) return result;
  if (result.empty()) result = v;
  using motion::impact_viscosity;
  const VecArray<D> all = extended<D>(s, v, Carried::yes, setup.no_slip);
  ScalarArray is_carried(s.n_real);
  parallel_for(s.n_real, [&](std::size_t a) {
    const bool own = viscosity(setup, state.particles.wave_speed[a]) <= setup.kinematic_viscosity;
    const bool slips = setup.soil_erodes || state.particles.in_seepage[a] == 0;
    is_carried[a] = !own && damped[a] && slips ? 1.0 : 0.0;
  });
  // Past soil that erodes the velocity jumps: beside it the gradient, which contains the jump, is not that of the free
  // water. It would make the row beside the soil lag behind the others by a quarter.
  const auto beside_jump = [&](std::size_t a) {
    if (is_carried[a] != 0.0) return false;
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k)
      if (const Index q = s.parent[s.other[k]]; q < s.n_real && is_carried[q] != 0.0) return true;
    return false;
  };
  ScalarArray has_gradient(s.n_real, 1.0);
  if (setup.soil_erodes) parallel_for(s.n_real, [&](std::size_t a) { has_gradient[a] = beside_jump(a) ? 0.0 : 1.0; });
  const auto smooth = s.template with_copies<double>(has_gradient);
  const auto gradients = s.with_copies(velocity_gradient);
  const auto wave_speeds = s.template with_copies<double>(state.particles.wave_speed);
  const auto carried = s.template with_copies<double>(is_carried);
  // Data of a point: velocity, velocity gradient, smoothing length, viscosity for shear and for noise; and 1 where
  // moving soil carries the water along, 0 elsewhere, -1 for a buffer, which does not count.
  constexpr std::size_t at_gradient = D, at_length = at_gradient + D * D, at_shear = at_length + 1,
                        at_noise = at_shear + 1, at_carried = at_noise + 1;
  PackedPoints<D, at_carried + 1> points(s.size());
  parallel_for(s.size(), [&](std::size_t j) {
    const Index q = s.parent[j];
    const bool particle = q < s.n_particles;
    Mat<D> gradient = Mat<D>::Zero();
    if (particle) gradient = gradients[q];
    if (particle && j >= s.n_base) {
      const Mat<D>& map = s.map[j - s.n_base];
      gradient =
          s.sticks(j, setup.no_slip) ? Mat<D>(-gradient * map.transpose()) : Mat<D>(map * gradient * map.transpose());
    }
    double* const row = points[j].x.data();
    Eigen::Map<Vec<D>>{row} = s.position[j];
    Eigen::Map<Vec<D>>{row + D} = all[j];
    Eigen::Map<Mat<D>>{row + D + at_gradient} = gradient;
    row[D + at_length] = s.length(j);
    row[D + at_shear] = row[D + at_noise] = 0.0;
    row[D + at_carried] = -1.0;
    if (!particle) return;
    const double wave_speed = wave_speeds[q], shear = viscosity(setup, wave_speed);
    // Numerical viscosity is no property of the water, and need not be exact: only the water's own is amplified.
    const bool own = shear <= setup.kinematic_viscosity;
    row[D + at_shear] = shear * (own ? s.amplification[q] : 1.0);
    row[D + at_noise] = smooth[q] * motion::noise_viscosity * setup.spacing * wave_speed;
    row[D + at_carried] = carried[q];
  });
  for_gradients<D, at_carried + 1, D>(
      s, points,
      [&](const auto& pair, const auto& factor, const auto* w, const auto* point, auto* sum)
          __attribute__((always_inline)) {
            using Number = NumberOf<decltype(pair)>;
            const double* const self = pair.self + D;
            // w = factor times the vector ba. The speed of approach is this sum over the length of w.
            Number approach{}, size = Number{} + 1e-300;
            for (std::size_t d = 0; d < D; ++d) {
              approach -= (point[d] - self[d]) * w[d];
              size += w[d] * w[d];
            }
            sqrt_in_place(size);
            max_in_place(approach, Number{});
            const Number impact = 0.5 * impact_viscosity * (self[at_length] + point[at_length]) * approach / size;
            const Number shear = 0.5 * (self[at_shear] + point[at_shear]) + impact,
                         noise = self[at_noise] * point[at_noise] > 0.0 ? 0.5 * (self[at_noise] + point[at_noise])
                                                                        : Number{};
            for (std::size_t d = 0; d < D; ++d) {
              Number unexplained = factor * (point[d] - self[d]);
              for (std::size_t e = 0; e < D; ++e)
                unexplained -= 0.5 * (self[at_gradient + d + D * e] + point[at_gradient + d + D * e]) * w[e];
              const Number part = shear * factor * (point[d] - self[d]) + noise * unexplained;
              sum[d] += point[at_carried] == self[at_carried] ? part : Number{};
            }
          },
      [&](std::size_t a, const double* total) __attribute__((always_inline)) {
        if (damped[a]) return;
        result[a] += 2.0 * interval * Eigen::Map<const Vec<D>>(total);
        result[a] -= interval * setup.central_force * s.position[a];
      });
  return result;
}

#define PORETWIN_INSTANTIATE(D)                                                                                    \
  template double viscosity(const Setup<D>&, double);                                                              \
  template VecArray<D> forced_velocity<D>(const Setup<D>&, const State<D>&, const Stencil<D>&, const SoilView<D>&, \
                                          std::span<const Mat<D>>, double);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::fluid
