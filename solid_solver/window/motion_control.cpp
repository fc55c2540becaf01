#include "solid_solver/window/motion_control.hpp"

#include "solid_solver/exchange/water_load.hpp"
#include "solid_solver/numerics/statics.hpp"
#include "solid_solver/numerics/steps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

namespace poretwin::solid {

template <int D>
double plastic_work(const Particles<D>& p, std::span<const double> plastic_before) {
  double work = 0.0;
  for (std::size_t i = 0; i < p.free(); ++i)
    if (const double strain = p.plastic_strain[i] - plastic_before[i]; strain > 0.0)
      work += p.volume[i] * std::numbers::sqrt3 * root_j2(p.stress[i]) * strain;
  return work;
}

template <int D>
void store_plastic_shear_ratio(std::span<const double> plastic_before, double interval, double factor,
                               State<D>& state) {
  const Particles<D>& p = state.particles;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double plastic = p.plastic_strain[i] - plastic_before[i];
    const double strain = interval * 2.0 / std::numbers::sqrt3 * root_j2(strain_rate<D>(state.nodes[i].gradient));
    if (plastic > 0.0) state.plastic_shear_ratio.set(i, factor * (strain > plastic ? plastic / strain : 1.0));
  }
}

template <int D>
bool inertia_matters(const Domain& domain, const Particles<D>& p, std::span<const Vec<D>> before, double dissipated,
                     double slow) {
  double kinetic = 0.0, creeping = 0.0;
  for (std::size_t i = 0; i < p.free(); ++i) {
    const Vec<D> change = before.empty() ? p.velocity[i] : Vec<D>(p.velocity[i] - before[i]);
    kinetic += 0.5 * p.mass[i] * change.squaredNorm();
    creeping += 0.5 * p.mass[i] * slow * slow;
  }
  return domain.sum(kinetic) > steps::noticed * domain.sum(dissipated) + domain.sum(creeping);
}

template <int D>
void control_motion(const Setup<D>& setup, const Drive<D>& drive, double interval, double dissipated, State<D>& state) {
  const Particles<D>& p = state.particles;
  const double slow = statics::woken_by * reference_acceleration(setup, state, drive) / near_critical_damping(setup);
  const bool moves = inertia_matters<D>(setup.domain, p, {}, dissipated * long_window(setup) / interval, slow);
  if (state.motion.moving && state.motion.calms(interval, !moves))
    fmt::print(stderr, "the soil is calm again at t = {:g} s\n", state.time);
  else if (!state.motion.moving && moves)
    state.motion.begins(long_window(setup));
}

template <int D>
std::pair<double, std::string> proposed_interval(const Setup<D>& setup, const State<D>& state) {
  std::pair<double, std::string> limit{coupling::no_limit, ""};
  const auto apply = [&](double interval, const char* why) {
    if (interval < limit.first) limit = {interval, why};
  };
  const bool coupled = setup.coupling.coupled;
  apply(next_load_after(setup, state.time) - state.time, "the next load begins");
  const double substeps_alone = state.sleep.asleep ? steps::alone_asleep : steps::alone;
  double alone = coupled ? coupling::no_limit : substeps_alone * setup.longest_substep;
  if (!coupled && setup.gauge_interval > 0.0) alone = std::min(alone, setup.gauge_interval);
  apply(alone, "soil alone: gauges and prescribed water are seen between windows");
  if ((state.any_yielded && !coupled) || state.motion.moving) apply(followed_window(setup), "the soil moves");
  if (!state.motion.moving) apply(state.motion.longest, "the soil creeps");
  return limit;
}

#define PORETWIN_INSTANTIATE(D)                                                                                  \
  template double plastic_work<D>(const Particles<D>&, std::span<const double>);                                 \
  template void store_plastic_shear_ratio<D>(std::span<const double>, double, double, State<D>&);                \
  template bool inertia_matters<D>(const Domain&, const Particles<D>&, std::span<const Vec<D>>, double, double); \
  template void control_motion<D>(const Setup<D>&, const Drive<D>&, double, double, State<D>&);                  \
  template std::pair<double, std::string> proposed_interval<D>(const Setup<D>&, const State<D>&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::solid
