#include "solid_solver/window/asleep.hpp"

#include <cmath>

namespace poretwin::solid {

template <int D>
bool sleeps_on(const Setup<D>& setup, const coupling::Window& window, const WaterInput<D>& water, Drive<D>& drive,
               State<D>& state) {
  if (!setup.sleeps || !state.sleep.asleep) return false;
  const std::size_t n = state.particles.size();
  drive.distributed.allocate(n);
  for (std::size_t i = 0; i < n; ++i)
    drive.distributed.set(i, water_force(setup, state, i, water.to[i], water.impulse, window.interval));
  const double reference = reference_acceleration(setup, state, drive);
  if (disturbed(setup, state, drive, loads_begun(setup, window.time), reference, setup.quiet.wake_above)) {
    state.sleep.asleep = false;
    return false;
  }
  for (auto* still : {&state.mean_velocity, &state.returned_impulse}) *still = {};
  state.dilation = {};
  store_water_force(setup, water.to, water.impulse, window.interval, state);
  state.time = window.time + window.interval;
  if (!setup.coupling.keep_points) ++state.revision;
  state.slept += std::ceil(window.interval / setup.longest_substep - 1e-9);
  return true;
}

template <int D>
void fall_asleep_if_quiet(const Setup<D>& setup, const Drive<D>& drive, double reference, State<D>& state) {
  const double rms = unrest(setup, state, drive, reference).rms;
  state.still_yields = state.any_yielded || (state.still_yields && rms >= setup.quiet.sleep_below);
  if (state.any_yielded || rms >= setup.quiet.sleep_below) return;
  stop(setup, state);
  state.sleep = {true, drive.distributed, state.external.saturation, loads_begun(setup, state.time)};
}

#define PORETWIN_INSTANTIATE(D)                                                                                     \
  template bool sleeps_on<D>(const Setup<D>&, const coupling::Window&, const WaterInput<D>&, Drive<D>&, State<D>&); \
  template void fall_asleep_if_quiet<D>(const Setup<D>&, const Drive<D>&, double, State<D>&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::solid
