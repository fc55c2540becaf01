#include "solid_solver/phase.hpp"

#include "common/case/gauge_kinds.hpp"
#include "common/core/error.hpp"
#include "solid_solver/erosion/erosion.hpp"
#include "solid_solver/exchange/publication.hpp"
#include "solid_solver/output/gauges.hpp"
#include "solid_solver/output/report.hpp"
#include "solid_solver/sleep/regions.hpp"
#include "solid_solver/solid.hpp"
#include "solid_solver/statics/initial_state.hpp"
#include "solid_solver/statics/safety.hpp"
#include "solid_solver/window/asleep.hpp"
#include "solid_solver/window/followed_window.hpp"

#include <algorithm>
#include <iterator>
#include <tuple>

namespace poretwin::solid {

using namespace coupling;  // NOLINT: the names of the contract

template <int D>
Solid<D>::Solid(const Case& scene, std::pair<Setup<D>, Particles<D>> made)
    : digest_(scene.digest()), setup_(std::move(made.first)) {
  if (setup_.coupling.coupled) quasi_static_ = QuasiStaticWindow<D>(made.second.position);
  state_ = laid_out(setup_, std::move(made.second));
}

template <int D>
Solid<D>::Solid(const Case& scene, const Domain& domain) : Solid(scene, set_up<D>(scene, domain)) {}

template <int D>
Solid<D>::Solid(const Case& scene, std::shared_ptr<Tiling<D>> tiling)
    : Solid(scene, set_up<D>(scene, std::move(tiling))) {}

template <int D>
void Solid<D>::initialise(const Inbox& inbox) {
  state_.external.pressure = take_pressure(setup_, inbox, state_.time, cache_, state_);
  if (setup_.initial_rest.sought) {
    rest_ = come_to_rest(setup_, state_);
    cache_.forget();
    if (setup_.water.is_prescribed())  // at the present positions of the soil
      state_.external.pressure = take_pressure(setup_, inbox, state_.time, cache_, state_);
    rebuild(setup_, state_);
    evaluate_forces(setup_, state_);
  } else {
    begin_under_earth_pressure(setup_, state_);
  }
  store_water_force(setup_, gradient_of(setup_, state_, state_.external.pressure, state_.time), {}, 1.0, state_);
  start_counting(state_);
  // Soil that moves at time zero is followed from the first window on: a search for equilibrium would stop it.
  const auto is_moving = [](const Vec<D>& v) { return !v.isZero(0.0); };
  if (setup_.coupling.coupled && setup_.domain.any(std::ranges::any_of(state_.particles.velocity, is_moving)))
    state_.motion.begins(long_window(setup_));
}

template <int D>
Outcome Solid<D>::advance(const Window& requested, const Inbox& inbox) {
  Window window = requested;
  window.saved = window.saved && !setup_.tiling;  // ranks receive signals at different times
  if (!(window.interval > 0.0)) return Outcome::reject(setup_.longest_substep, "a window must be longer than 0 s");
  expect_bearable_pressure(setup_, state_.particles);
  quasi_static_.begin_window();
  const WaterInput<D> water = take_water(setup_, inbox, window, cache_, state_);
  Outcome outcome = cross(window, water);
  if (outcome.accepted) erode(setup_, window.interval, water.free_velocity, state_);
  return outcome;
}

template <int D>
Outcome Solid<D>::cross(const Window& window, const WaterInput<D>& water) {
  const CrossedAs crossed = way_through(setup_, state_, window.interval);
  Tracking<D> tracking = make_tracking(setup_, state_, window, crossed, water, quasi_static_.found(), cache_);
  if (sleeps_on(setup_, window, water, tracking.drive, state_)) return Outcome::accept();
  clear_answer(water, state_);
  if (!crossed.rests) {
    follow_window(setup_, window, crossed.steps, water, std::move(tracking), state_);
    return Outcome::accept();
  }
  wake_regions(setup_, state_);
  const auto [outcome, hint] = quasi_static_.advance(setup_, window, water, tracking, state_);
  hint_.add(hint);
  return outcome;
}

template <int D>
void Solid<D>::save() {
  saved_ = state_;
  hint_ = {};
}

template <int D>
void Solid<D>::restore() {
  state_ = saved_;
  hint_.apply(long_window(setup_), state_.motion);
  cache_.forget();
}

template <int D>
void Solid<D>::take_over(State<D> state) {
  state_ = std::move(state);
  cache_.forget();
}

template <int D>
void Solid<D>::archive(Archive& archive) {
  if (setup_.tiling) throw Error(ExitCode::failure, "checkpoints hold the soil of all ranks, this is one rank's share");
  archive(state_, rest_, safety_);
  cache_.forget();
}

template <int D>
Contract Solid<D>::contract() const {
  Contract out{D, digest_, standard_fields(Role::solid, D),
               standard_fields(Role::fluid, D, setup_.water.is_field ? WaterAs::field : WaterAs::particles)};
  if (setup_.water.has_basins()) out.takes.push_back(basin_level_field());
  if (setup_.erodes) out.takes.push_back(free_water_fields(D).front());
  return out;
}

template <int D>
std::pair<double, std::string> Solid<D>::proposal() const {
  return proposed_interval(setup_, state_);
}

template <int D>
Publication Solid<D>::publish() const {
  Publication out = published(setup_, state_, cache_);
  std::tie(out.proposed_interval, out.limited_by) = proposal();
  out.unsettled = quasi_static_.unsettled();
  return out;
}

template <int D>
OutputFrame Solid<D>::frame() const {
  OutputFrame frame = frame_of(setup_, state_);
  if (asks_for(setup_.gauges, "solid", "factor_of_safety"))
    frame.fields.push_back(failing_strain_field(safety_.failing_strain, "the factor of safety that was read last"));
  return frame;
}

template <int D>
std::vector<GaugeReading> Solid<D>::gauges() const {
  auto readings = read_gauges<D>(setup_, state_);
  std::ranges::move(read_factor_of_safety<D>(setup_, state_, safety_), std::back_inserter(readings));
  return readings;
}

template <int D>
std::map<std::string, double> Solid<D>::counters() const {
  return counters_of(state_, rest_);
}

template <int D>
std::vector<Warning> Solid<D>::warnings() const {
  return warnings_of(setup_, state_, rest_);
}

template class Solid<2>;
template class Solid<3>;

std::unique_ptr<Phase> make_solid(const Case& scene) {
  if (scene.general.dimension == 3) return std::make_unique<Solid<3>>(scene);
  return std::make_unique<Solid<2>>(scene);
}

}  // namespace poretwin::solid
