#include "solid_solver/statics/safety.hpp"

#include "common/coupling/interrupt.hpp"
#include "solid_solver/exchange/water_load.hpp"
#include "solid_solver/statics/rest.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin::solid {
namespace {

/// The soil at rest, without any memory of how it came to rest except what frames contain (see factor_of_safety).
/// water: force on each particle [N].
template <int D>
State<D> at_rest(const Setup<D>& setup, const State<D>& state, const VecArray<D>& water) {
  State<D> trial = state;
  Particles<D>& p = trial.particles;
  trial.sleep = {};
  trial.regions = {};
  trial.backing = {};
  std::fill(trial.yielded.begin(), trial.yielded.end(), char{0});
  trial.any_yielded = false;
  trial.since_upkeep = 0.0;
  std::fill(p.wall_slope.begin(), p.wall_slope.end(), Vec<D>::Zero());
  for (std::size_t i = 0; i < p.size(); ++i) trial.body[i] = (p.mass[i] * setup.gravity + water[i]) / p.volume[i];
  // The gradient of the displacement, by the operator that gives the velocity's gradient. Hourglass control takes from
  // it what part of the displacement is linear.
  p.velocity = p.displacement;
  p.slip = p.slipped;
  rebuild(setup, trial);
  for (std::size_t i = 0; i < p.free(); ++i) trial.nodes[i].deformation = trial.nodes[i].gradient;
  stop(setup, trial);
  return trial;
}

/// How the soil fails in a trial.
template <int D>
struct Failure {
  ScalarArray strain;        ///< plastic strain of each free particle
  VecArray<D> displacement;  ///< m
};

/// Whether the soil stands with its strength divided by `factor`; empty if interrupted. failure: how the soil fails,
/// set if it does not stand. water: force on each particle [N].
template <int D>
std::optional<bool> stands(const Setup<D>& setup, const State<D>& state, const VecArray<D>& water, double factor,
                           Failure<D>& failure) {
  const Setup<D> weak = weaker(setup, factor);
  State<D> trial = at_rest(weak, state, water);
  bool given_up = false;
  const auto external = [&](Drive<D>& drive, bool rebuilt) {
    given_up = given_up || coupling::interrupted();
    if (!rebuilt) return;
    drive.traction = load_forces<D>(weak, trial, state.time);
    drive.distributed = water;
  };
  RestSearch search;
  search.drifts = true;
  const RestReport rest = find_rest<D>(
      weak, search, trial, external, [](const RestReport&) {}, given_up);
  if (given_up) return {};
  if (rest.reached()) return true;
  const std::size_t n = state.particles.free();
  failure.strain.resize(n);
  failure.displacement.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    failure.strain[i] = trial.particles.plastic_strain[i] - state.particles.plastic_strain[i];
    failure.displacement[i] = trial.particles.displacement[i] - state.particles.displacement[i];
  }
  return false;
}

}  // namespace

template <int D>
Vec<D> standing_water_force(const Setup<D>& setup, const State<D>& state, std::size_t i) {
  if (!state.external.pressure_gradient.is_allocated()) return Vec<D>::Zero();
  const Vec<D> gradient = state.external.pressure_gradient[i];
  const Vec<D> force =
      setup.water.drags ? steady_water_force(setup, state, i, gradient) : water_force(setup, state, i, gradient);
  return force / state.particles.volume[i];
}

template <int D>
std::optional<FactorOfSafety<D>> factor_of_safety(const Setup<D>& setup, const State<D>& state,
                                                  const VecArray<D>& water, const BorderSearch& search) {
  Failure<D> failure;  // of the last trial that failed, which is nearest to the factor of safety
  const auto border = find_border(search, [&](double factor) { return stands(setup, state, water, factor, failure); });
  if (!border) return {};
  return FactorOfSafety<D>{*border, std::move(failure.strain), std::move(failure.displacement)};
}

BorderSearch search_near(double last, double tolerance) {
  BorderSearch search;
  search.tolerance = tolerance;
  if (last > 0.0) {
    search.guess = last;
    search.ratio = 1.0 + tolerance;
  }
  return search;
}

template <int D>
std::vector<GaugeReading> read_factor_of_safety(const Setup<D>& setup, const State<D>& state, SafetyRecord& last) {
  std::vector<GaugeReading> readings;
  const double read_before = last.time;
  for (const Gauge& gauge : setup.gauges) {
    if (gauge.kind != "factor_of_safety") continue;
    const auto turns = [&gauge](double time) { return std::floor(time / gauge.every * (1.0 + 1e-9)); };
    if (turns(state.time) <= turns(read_before)) continue;
    VecArray<D> water(state.particles.size());
    for (std::size_t i = 0; i < water.size(); ++i)
      water[i] = state.particles.volume[i] * standing_water_force(setup, state, i);
    auto found = factor_of_safety(setup, state, water, search_near(last.factor, statics::safety_tolerance));
    if (!found) continue;
    last = {std::isfinite(found->fails) ? found->factor() : 0.0, state.time, std::move(found->failing_strain)};
    readings.push_back({gauge.name, found->factor(), "1"});
    readings.push_back({gauge.name + "_error", found->error(), "1"});
  }
  return readings;
}

#define PORETWIN_INSTANTIATE(D)                                                                                       \
  template Vec<D> standing_water_force<D>(const Setup<D>&, const State<D>&, std::size_t);                             \
  template std::optional<FactorOfSafety<D>> factor_of_safety<D>(const Setup<D>&, const State<D>&, const VecArray<D>&, \
                                                                const BorderSearch&);                                 \
  template std::vector<GaugeReading> read_factor_of_safety<D>(const Setup<D>&, const State<D>&, SafetyRecord&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::solid
