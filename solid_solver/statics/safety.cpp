#include "solid_solver/statics/safety.hpp"

#include "common/coupling/interrupt.hpp"
#include "solid_solver/exchange/water_load.hpp"
#include "solid_solver/statics/rest.hpp"

#include <cmath>

namespace poretwin::solid {
namespace {

/// The water's force on each particle [N]; where water and skeleton exchange drag, that of steady flow.
template <int D>
VecArray<D> water_forces(const Setup<D>& setup, const State<D>& state) {
  VecArray<D> force(state.particles.size(), Vec<D>::Zero());
  if (!state.external.pressure_gradient.is_allocated()) return force;
  for (std::size_t i = 0; i < force.size(); ++i) {
    const Vec<D> gradient = state.external.pressure_gradient[i];
    force[i] =
        setup.water.drags ? steady_water_force(setup, state, i, gradient) : water_force(setup, state, i, gradient);
  }
  return force;
}

/// Whether the soil stands with its strength divided by `factor`; empty where the run was interrupted. strain: where
/// the soil fails, the plastic strain of each particle in the trial. water: force on each particle [N].
template <int D>
std::optional<bool> stands(const Setup<D>& setup, const State<D>& state, const VecArray<D>& water, double factor,
                           ScalarArray& strain) {
  const Setup<D> weak = weaker(setup, factor);
  State<D> trial = state;
  trial.sleep = {};
  trial.regions = {};
  stop(weak, trial);
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
  strain.resize(state.particles.free());
  for (std::size_t i = 0; i < strain.size(); ++i)
    strain[i] = trial.particles.plastic_strain[i] - state.particles.plastic_strain[i];
  return false;
}

}  // namespace

template <int D>
std::optional<FactorOfSafety> factor_of_safety(const Setup<D>& setup, const State<D>& state,
                                               const BorderSearch& search) {
  const VecArray<D> water = water_forces(setup, state);
  ScalarArray strain;  // of the last trial that failed, which is the one nearest to the factor of safety
  const auto border = find_border(search, [&](double factor) { return stands(setup, state, water, factor, strain); });
  if (!border) return {};
  return FactorOfSafety{*border, std::move(strain)};
}

template <int D>
std::vector<GaugeReading> read_factor_of_safety(const Setup<D>& setup, const State<D>& state, SafetyRecord& last) {
  std::vector<GaugeReading> readings;
  const double read_before = last.time;
  for (const Gauge& gauge : setup.gauges) {
    if (gauge.kind != "factor_of_safety") continue;
    const auto turns = [&gauge](double time) { return std::floor(time / gauge.every * (1.0 + 1e-9)); };
    if (turns(state.time) <= turns(read_before)) continue;
    BorderSearch search;
    search.tolerance = statics::safety_tolerance;
    if (last.factor > 0.0) {
      search.guess = last.factor;
      search.ratio = 1.0 + statics::safety_tolerance;
    }
    auto found = factor_of_safety(setup, state, search);
    if (!found) continue;
    last = {std::isfinite(found->fails) ? found->factor() : 0.0, state.time, std::move(found->failing_strain)};
    readings.push_back({gauge.name, found->factor(), "1"});
    readings.push_back({gauge.name + "_error", found->error(), "1"});
  }
  return readings;
}

#define PORETWIN_INSTANTIATE(D)                                                                                      \
  template std::optional<FactorOfSafety> factor_of_safety<D>(const Setup<D>&, const State<D>&, const BorderSearch&); \
  template std::vector<GaugeReading> read_factor_of_safety<D>(const Setup<D>&, const State<D>&, SafetyRecord&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::solid
