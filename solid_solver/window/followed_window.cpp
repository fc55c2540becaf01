#include "solid_solver/window/followed_window.hpp"

#include "common/coupling/interrupt.hpp"
#include "solid_solver/dynamics/plate_motion.hpp"
#include "solid_solver/numerics/sleep.hpp"
#include "solid_solver/sleep/regions.hpp"
#include "solid_solver/window/asleep.hpp"
#include "solid_solver/window/motion_control.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin::solid {
namespace {

/// Whether the fluid's pressure, a mean over the window, acts unchanged in the whole window: on moving soil, and where
/// a load begins with the window and raises the pressure immediately. Otherwise the soil goes from rest to rest, and
/// the pressure changes linearly in the window.
template <int D>
bool feels_the_mean(const Setup<D>& setup, const State<D>& state, const coupling::Window& window) {
  return state.motion.moving || std::ranges::any_of(setup.loads, [&](const auto& patch) {
           return has_begun(patch.start, window.time) && !has_begun(patch.start, window.time - 0.5 * window.interval);
         });
}

/// Whether no water acts on the soil in the window.
template <int D>
bool is_dry(const State<D>& state, const WaterInput<D>& water) {
  const auto acts = [](double x) { return x != 0.0; };
  return std::none_of(water.impulse.begin(), water.impulse.end(), acts) &&
         std::none_of(state.external.coverage.begin(), state.external.coverage.end(), acts) &&
         std::all_of(water.from.begin(), water.from.end(), [](const Vec<D>& g) { return g.isZero(0.0); });
}

/// Forces of the loads, evaluated anew only where they may have changed.
template <int D>
class Loads {
 public:
  explicit Loads(const Setup<D>& setup)
      : varies_(std::ranges::any_of(setup.loads, [](const auto& patch) { return patch.factor.has_value(); })) {}
  void act(const Setup<D>& setup, const State<D>& state, double now, VecArray<D>& traction) {
    const bool starts = has_begun(next_start_, now) && known_;
    if (known_ && !starts && !varies_ && state.rebuilds <= rebuilds_) return;
    if (!setup.loads.empty()) traction = load_forces<D>(setup, state, now + 1e-9 * std::abs(now));
    known_ = true;
    rebuilds_ = state.rebuilds;
    next_start_ = next_load_after(setup, now);
  }

 private:
  bool varies_, known_ = false;
  double rebuilds_ = -1.0, next_start_ = -1.0;
};

}  // namespace

template <int D>
CrossedAs way_through(const Setup<D>& setup, const State<D>& state, double interval) {
  // A field has no inertia: soil that goes from rest to rest with a field does so in windows of any length.
  if (setup.coupling.coupled && !state.motion.moving && (setup.water.is_field || interval > followed_window(setup)))
    return {true, 1};
  return {false,
          std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(interval / setup.longest_substep - 1e-9)))};
}

template <int D>
void follow_window(const Setup<D>& setup, const coupling::Window& window, std::size_t steps, const WaterInput<D>& water,
                   Tracking<D> tracking, State<D>& state) {
  const Particles<D>& p = state.particles;
  const std::size_t n = p.size();
  const double interval = window.interval, dt = interval / static_cast<double>(steps);
  Drive<D>& drive = tracking.drive;
  VecArray<D> displacement;
  ScalarArray plastic_before;
  if (water.tracks) {
    displacement = p.displacement;
    plastic_before = p.plastic_strain;
  }
  double reference = 0.0;
  const bool mean = feels_the_mean(setup, state, window), dry = is_dry(state, water);
  drive.damping_of_calm = setup.quiet.damping ? near_critical_damping(setup) : 0.0;
  // Zeros, which would not go with particles to other ranks: these have no water.
  if (setup.tiling) drive.distributed = {};
  Loads<D> loads(setup);
  for (std::size_t k = 0; k < steps; ++k) {
    loads.act(setup, state, window.time + static_cast<double>(k) * dt, drive.traction);
    const double due = static_cast<double>(k + 1) / static_cast<double>(steps);  // fraction of the window that has
                                                                                 // passed at the end of the substep
    for (std::size_t i = 0; i < n && water.tracks; ++i)
      drive.target[i] = tracking.start[i] + (setup.parallel ? 1.0 : due) * tracking.change[i];
    const double share = mean ? 1.0 : due;
    for (std::size_t i = 0; i < n && !dry; ++i)
      drive.distributed.set(
          i,
          water_force<D>(setup, state, i, (1.0 - share) * water.from[i] + share * water.to[i], water.impulse, interval),
          n);
    if (setup.sleeps && k == 0) {
      reference = reference_acceleration(setup, state, drive);
      const bool calm = unrest(setup, state, drive, reference).rms < sleep::damped_below * setup.quiet.wake_above;
      drive.damping = setup.quiet.damping && calm && !state.still_yields ? near_critical_damping(setup) : 0.0;
      if (drive.damping > 0.0) state.damped += static_cast<double>(steps);
    }
    if (!setup.plates.empty()) drive.plates = orders_at(setup.plates, window.time + due * interval);
    if (window.saved) coupling::give_up_if_interrupted();
    substep<D>(setup, dt, drive, state);
    watch_regions<D>(setup, drive, dt, state);
  }
  check_sound(setup, state, window.time);
  count_pulls(setup, state);
  store_water_force(setup, water.to, water.impulse, interval, state);
  state.mean_velocity.allocate(water.tracks ? n : 0);
  for (std::size_t i = 0; i < n && water.tracks; ++i)
    state.mean_velocity.set(i, (p.displacement[i] - displacement[i]) / interval);
  if (water.tracks) store_plastic_shear_ratio(plastic_before, interval, 1.0, state);
  if (setup.sleeps) fall_asleep_if_quiet(setup, drive, reference, state);
  state.time = window.time + interval;
  state.substeps += static_cast<double>(steps);
  ++state.revision;
  if (!setup.coupling.coupled) return;
  const double plastic = water.tracks ? plastic_work<D>(p, plastic_before) : 0.0;
  control_motion(setup, drive, interval, tracking.dissipated + plastic, state);
}

#define PORETWIN_INSTANTIATE(D)                                                                               \
  template CrossedAs way_through<D>(const Setup<D>&, const State<D>&, double);                                \
  template void follow_window<D>(const Setup<D>&, const coupling::Window&, std::size_t, const WaterInput<D>&, \
                                 Tracking<D>, State<D>&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::solid
