#include "solid_solver/statics/initial_state.hpp"

#include "common/core/error.hpp"
#include "common/coupling/interrupt.hpp"
#include "solid_solver/discretisation/ranks.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace poretwin::solid {

template <int D>
State<D> laid_out(Setup<D>& setup, Particles<D> particles) {
  State<D> state;
  state.particles = std::move(particles);
  begin_with_share(setup, state);
  const std::size_t n = state.particles.size();
  state.body.assign(n, Vec<D>::Zero());
  state.force.assign(n, {});
  for (std::size_t i = 0; i < n; ++i) {
    const Index soil = state.particles.material[i];
    const double initial = setup.soils[soil].initial_saturation;
    if (initial > 0.0 || setup.softened_by_water[soil]) state.external.saturation.set(i, initial, n);
  }
  state.yielded.assign(n, 0);
  rebuild(setup, state);
  state.rebuilds = 0.0;
  evaluate_forces(setup, state);
  measure_loads(state, setup);
  return state;
}

template <int D>
void complete(const Setup<D>& setup, State<D>& state) {
  begin_with_share(setup, state);
  rebuild_lists(setup, state);
  evaluate_forces(setup, state);
}

namespace {

constexpr double before_everything = -1e300;  // s, a time at which only permanent loads act

/// What acts on the soil before time zero: the permanent loads and the water.
template <int D>
void drive_before_everything(const Setup<D>& setup, State<D>& state, Drive<D>& drive) {
  const std::size_t n = state.particles.size();
  drive.plates = orders_at(setup.plates, before_everything);
  state.external.pressure_gradient = gradient_of(setup, state, state.external.pressure, before_everything);
  drive.traction = load_forces<D>(setup, state, before_everything);
  drive.distributed.allocate(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec<D> gradient = state.external.pressure_gradient[i];
    drive.distributed.set(i, setup.initial_rest.bears_seepage ? steady_water_force(setup, state, i, gradient)
                                                              : water_force(setup, state, i, gradient));
  }
}

}  // namespace

template <int D>
void begin_under_earth_pressure(const Setup<D>& setup, State<D>& state) {
  const auto has_ratio = [](const Soil& soil) { return soil.earth_pressure_at_rest.has_value(); };
  if (!std::ranges::any_of(setup.soils, has_ratio)) return;
  Drive<D> drive;
  drive_before_everything(setup, state, drive);
  start_from_earth_pressure<D>(setup, setup.soils, drive, state);
  Particles<D>& p = state.particles;
  for (std::size_t i = 0; i < p.size(); ++i) setup.models[p.material[i]]->initial(p.stress[i], p.state_of(i));
}

template <int D>
RestReport come_to_rest(const Setup<D>& setup, State<D>& state) {
  const VecArray<D> initial = state.particles.velocity, slip = state.particles.slip;
  stop(setup, state);
  begin_under_earth_pressure(setup, state);
  auto external = [&](Drive<D>& drive, bool rebuilt) {
    if (coupling::interrupted())
      throw Error(ExitCode::interrupted,
                  "interrupted in the search for the soil's rest: there is nothing to resume from yet");
    if (rebuilt) drive_before_everything(setup, state, drive);
  };
  RestSearch search;
  search.drifts = true;
  const RestReport rest = find_rest<D>(setup, search, state, external, [](const RestReport& r) {
    fmt::print(stderr, "rest of the soil: largest acceleration {:.2g} of the driving one after {} steps, until {:g}\n",
               r.residual, r.steps, r.criterion);
  });
  state.particles.velocity = initial;
  state.particles.slip = slip;
  return rest;
}

template <int D>
void start_counting(State<D>& state) {
  const auto& moved = state.particles.displacement;
  if (std::any_of(moved.begin(), moved.end(), [](const Vec<D>& u) { return !u.isZero(0.0); }))
    state.rest_displacement = moved;
  std::fill(state.yielded.begin(), state.yielded.end(), char{0});
  state.any_yielded = false;
  state.from_outside.setZero();
  ++state.revision;
}

#define PORETWIN_INSTANTIATE(D)                                            \
  template State<D> laid_out<D>(Setup<D>&, Particles<D>);                  \
  template void complete<D>(const Setup<D>&, State<D>&);                   \
  template void begin_under_earth_pressure<D>(const Setup<D>&, State<D>&); \
  template RestReport come_to_rest<D>(const Setup<D>&, State<D>&);         \
  template void start_counting<D>(State<D>&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::solid
