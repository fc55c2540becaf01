#include "fluid_solver/motion/step_limits.hpp"

#include "fluid_solver/motion/viscosity.hpp"
#include "fluid_solver/numerics/motion.hpp"
#include "fluid_solver/numerics/steps.hpp"
#include "fluid_solver/pressure/eisph.hpp"
#include "fluid_solver/regimes.hpp"

#include <cmath>
#include <functional>

namespace poretwin::fluid {

namespace {

/// Longest window in which particles can follow the central force [s].
template <int D>
double central_interval(const Setup<D>& setup) {
  const double force = setup.central_force;
  return force > 0.0 ? steps::central_courant / std::sqrt(force) : HUGE_VAL;
}

/// Longest window in which the viscosities of free water are stable [s].
template <int D>
double viscous_interval(const Setup<D>& setup, double wave_speed) {
  const double all = viscosity(setup, wave_speed) + motion::noise_viscosity * setup.spacing * wave_speed;
  return all > 0.0 ? steps::viscous_courant * setup.spacing * setup.spacing / all : HUGE_VAL;
}

/// Bounds on the change of a level or load in one window, whatever the water's speed: half a spacing of water. Tables
/// need not make windows shorter than a fall through a spacing, since seepage responds to nothing faster.
template <int D>
AllowedChange allowed_change(const Setup<D>& setup, double longest) {
  const double rise = steps::wanted_rise * setup.spacing;
  return {rise, rise * setup.density * setup.gravity_or_standard,
          steps::least_for_tables * std::sqrt(setup.spacing / setup.gravity_or_standard), longest};
}

/// Applies the limits that tables of loads set to the window from `now` [s] on. Where the skeleton responds, the window
/// resolves the first wave of a load that begins.
template <int D>
void limit_by_loads(const Setup<D>& setup, double first_interval, double now,
                    const std::function<void(double, const std::string&)>& apply) {
  if (!setup.coupled) return;
  const auto allowed = allowed_change(setup, HUGE_VAL);
  for (const auto& load : setup.loads)
    if (load.factor && load.traction > 0.0)
      apply(std::max(allowed.shortest, unchanged_for(*load.factor, now, allowed.pressure / load.traction)),
            "a load that changes");
  if (first_interval > 0.0 && load_begins(setup, now)) apply(first_interval, "a load that begins");
}

}  // namespace

template <int D>
double wave_interval(const Setup<D>& setup) {
  return setup.weight.norm() > 0.0
             ? steps::wave_courant * std::sqrt(setup.spacing * setup.density / setup.weight.norm())
             : HUGE_VAL;
}

template <int D>
double quasi_static_speed(const Setup<D>& setup) {
  return setup.weight.norm() > 0.0 ? steps::quasi_static * wave_interval(setup) * setup.weight.norm() / setup.density
                                   : HUGE_VAL;
}

template <int D>
double free_interval(const Setup<D>& setup, const Particles<D>& p, std::size_t a) {
  const double courant = steps::free_courant * spacing_of<D>(p.volume[a]) / std::max(p.velocity[a].norm(), 1e-300);
  return std::min({wave_interval(setup), central_interval(setup), viscous_interval(setup, p.wave_speed[a]), courant});
}

template <int D>
bool load_begins(const Setup<D>& setup, double time) {
  return std::any_of(setup.loads.begin(), setup.loads.end(), [&](const LoadInTime& load) {
    return load.start && *load.start > 0.0 && std::abs(time - *load.start) <= 1e-9 * *load.start;
  });
}

/// The first window is a fifth of the time in which a wave in the soil crosses a spacing.
///
/// In elastic soil that is wet from the start the first window is a fifth of the drainage time of a spacing, if that is
/// longer. Until a spacing has drained, the water fixes the grains and only shear moves; the solid would then refuse
/// such a long window. Soil that may slide begins to do so immediately. interval [s]: the window in which the soil
/// first responds; 0 before it.
template <int D>
void begin_control(const Setup<D>& setup, const SoilView<D>& view, double interval, State<D>& state) {
  const auto& n = state.particles.void_fraction;
  double stiffest = 0.0, drains = 0.0;
  for (std::size_t a = 0; a < view.size(); ++a) {
    stiffest = std::max(stiffest, view.modulus[a]);
    if (!setup.soil_yields && view.modulus[a] > 0.0 && view.drag[a] > 0.0)
      drains = std::max(drains,
                        n[a] * n[a] * view.modulus[a] / (view.drag[a] * setup.spacing * setup.spacing));  // c_v / dx^2
  }
  stiffest = setup.domain.max(stiffest);
  drains = setup.domain.max(drains);
  if (!setup.responds || stiffest <= 0.0) return;
  state.first_interval = steps::first_wave * setup.spacing / std::sqrt(stiffest / setup.density);
  state.controlled = std::max(state.first_interval, interval > 0.0 ? interval
                                                    : drains > 0.0 ? steps::first_drained / drains
                                                                   : 0.0);
}

template <int D>
void control_interval(const Setup<D>& setup, const ScalarArray& before, double interval, State<D>& state) {
  const auto& now = state.particles.pressure;
  if (state.controlled <= 0.0 || setup.domain.all(now.empty())) return;
  const auto& x = state.particles.position;
  double sum = 0.0, lower = HUGE_VAL, upper = -lower, lightest = lower, heaviest = upper;
  for (std::size_t a = 0; a < now.size(); ++a) {
    lightest = std::min(lightest, setup.weight.dot(x[a]));
    heaviest = std::max(heaviest, setup.weight.dot(x[a]));
    sum += (now[a] - before[a]) * (now[a] - before[a]);
    lower = std::min(lower, now[a]);
    upper = std::max(upper, now[a]);
  }
  for (const auto& c : state.columns)
    if (c.wet) {
      lower = std::min(lower, c.pressure);
      upper = std::max(upper, c.pressure);
    }
  const Domain& domain = setup.domain;
  lower = domain.min(lower);
  upper = domain.max(upper);
  lightest = domain.min(lightest);
  heaviest = domain.max(heaviest);
  state.widest_range = std::max(state.widest_range, upper - lower);
  // The pressure of water at rest has no range beyond the hydrostatic one: rounding must not shorten its windows. The
  // weight of one spacing of water is the finest pressure to be resolved.
  const double range =
      std::max({upper - lower, steps::widest_share * state.widest_range,
                steps::hydrostatic_share * (heaviest - lightest), setup.weight.norm() * setup.spacing});
  const double mean = domain.sum(sum) / domain.sum(static_cast<double>(now.size()));
  state.pressure_change = range > 0.0 ? std::sqrt(mean) / range : 0.0;
  const double target =
      state.pressure_change > 0.0 ? interval * steps::wanted_change / state.pressure_change : HUGE_VAL;
  const double least =
      steps::shrinks_to * std::min(interval, state.controlled);  // another limit may have shortened this window
  state.controlled = std::max(std::clamp(target, least, steps::grows_to * state.controlled),
                              steps::shortest_over_first * state.first_interval);
}

/// Limit of the next window where all water seeps, since the motion of its particles is extrapolated from two windows.
/// The sum over particles cancels the noise of single ones. Where particles pass into other soils their speed jumps in
/// steady flow, too.
template <int D>
void limit_by_slowing(const Setup<D>& setup, const VecArray<D>& velocity_before, double interval, State<D>& state) {
  state.window_limits.clear();
  const auto& p = state.particles;
  if (setup.coupled || setup.scheme != FluidCase::Scheme::projection || is_driven_by_pressure(setup, state) ||
      !setup.domain.all_of(p.size(), [&](std::size_t a) { return p.in_seepage[a] != 0; }))
    return;
  const auto open = [](const FaceColumn<D>& c) { return c.in_soil && !c.wet; };
  if (std::any_of(state.columns.begin(), state.columns.end(), open)) {
    const ColumnFinder<D> finder(state.columns);
    const double fastest = setup.domain.max_over(p.size(), 0.0, [&](std::size_t a) {
      const int i = p.surface[a] == Surface::interior ? -1 : finder.nearest(p.position[a]);
      if (i < 0) return 0.0;
      const auto& c = state.columns[static_cast<std::size_t>(i)];
      return open(c) ? -c.normal.dot(p.velocity[a]) / c.spacing : 0.0;
    });
    if (fastest > 0.0)
      state.window_limits.push_back({steps::wanted_exit / fastest,
                                     "an eighth of a spacing per window of water that leaves through a seepage face"});
  }
  const double change = setup.domain.sum_over(
      p.size(), [&](std::size_t a) { return p.mass[a] * p.velocity[a].dot(p.velocity[a] - velocity_before[a]); });
  if (change == 0.0) return;
  const double whole =
      setup.domain.sum_over(p.size(), [&](std::size_t a) { return p.mass[a] * p.velocity[a].squaredNorm(); });
  const double mass = setup.domain.sum_over(p.size(), [&](std::size_t a) { return p.mass[a]; });
  const double altered = interval * std::abs(change) / std::sqrt(whole * mass) / setup.spacing;
  state.window_limits.push_back(
      {interval * std::max(0.5, std::sqrt(steps::wanted_slowing / altered)), "seepage that slows down"});
}

/// Limit of the next window by water in coarse soil, where inertia dominates. With its speed and the acceleration of
/// the last window, a particle moves by at most a quarter spacing. The speed alone does not show how fast water will be
/// if the base, or the surface that came down on it, has just stopped it.
template <int D>
void limit_by_acceleration(const Setup<D>& setup, const SoilView<D>& view, const VecArray<D>& velocity_before,
                           double interval, State<D>& state) {
  if (is_driven_by_pressure(setup, state)) return;
  const auto& p = state.particles;
  const auto in_coarse = [&](std::size_t a) {
    return p.in_seepage[a] != 0 && view.mask[a] > 0.5 && !is_drag_dominated<D>(setup, state.particles, view, a);
  };
  const bool coarse = !parallel_all(p.size(), [&](std::size_t a) { return !in_coarse(a); });
  double longest = HUGE_VAL;
  for (std::size_t a = 0; coarse && a < p.size(); ++a) {
    if (!in_coarse(a)) continue;
    const double spacing = spacing_of<D>(p.volume[a]), speed = p.velocity[a].norm();
    const double acceleration = (p.velocity[a] - velocity_before[a]).norm() / interval;
    if (acceleration == 0.0) continue;
    longest = std::min(longest, 0.5 * spacing / (speed + std::sqrt(speed * speed + acceleration * spacing)));
  }
  longest = setup.domain.min(longest);
  if (std::isfinite(longest))
    state.window_limits.push_back({longest, "a quarter spacing per window of water in coarse soil that accelerates"});
}

/// Limits of the next window by an explicit scheme, from the present state of water and soil.
template <int D>
void limit_scheme(const Setup<D>& setup, const SoilView<D>& view, State<D>& state) {
  const auto& p = state.particles;
  if (setup.scheme == FluidCase::Scheme::projection) return;
  double pressure = 0.0, fastest = 0.0;
  for (std::size_t a = 0; a < p.size(); ++a) {
    pressure = std::max(pressure, p.pressure[a] + setup.weight.dot(p.position[a] - setup.origin));
    fastest = std::max(fastest, p.velocity[a].norm());
  }
  for (const auto& c : state.columns)
    if (c.wet) pressure = std::max(pressure, c.pressure + setup.weight.dot(c.foot - setup.origin));
  pressure = setup.domain.max(std::max(pressure, setup.density * fastest * fastest));
  double sweep = HUGE_VAL, drag = HUGE_VAL, skeleton = HUGE_VAL;
  const bool implicit_drag = setup.scheme != FluidCase::Scheme::eisph_explicit_drag;
  for (std::size_t a = 0; a < p.size(); ++a) {
    const double n = p.void_fraction[a], C = view.drag[a];
    sweep = std::min(sweep, sweep_interval<D>(n, implicit_drag ? C : 0.0, setup.density, pressure,
                                              spacing_of<D>(p.volume[a]), setup.sweeps));
    if (C <= 0.0) continue;
    drag = std::min(drag, n * setup.density / C);
    if (setup.coupled) skeleton = std::min(skeleton, view.density[a] * n * n / C);
  }
  state.window_limits.push_back({sweep, "compression under explicit sweeps"});
  if (!implicit_drag) state.window_limits.push_back({drag, "explicit drag"});
  state.window_limits.push_back({skeleton, "a skeleton that does not respond inside the window"});
}

/// Particles that left soil at rest in the last window at a place without a face: they are about to fall, although
/// their regime is still that of the window's start. Empty: there are none. Only water at a surface counts, since other
/// water would pass into free water.
template <int D>
std::vector<char> left_soil(const Setup<D>& setup, const State<D>& state) {
  const auto& p = state.particles;
  std::vector<char> left;
  if (setup.coupled || setup.ground.strata().empty() || state.full) return left;
  std::optional<ColumnFinder<D>> finder;
  for (std::size_t a = 0; a < p.size(); ++a) {
    const auto& x = p.position[a];
    if (p.in_seepage[a] == 0 || p.surface[a] == Surface::interior || setup.ground.at(x)) continue;
    if (!finder) finder.emplace(state.columns);
    if (finder->nearest(x) >= 0) continue;
    left.resize(p.size(), 0);
    left[a] = 1;
  }
  return left;
}

template <int D>
std::pair<double, std::string> time_limit(const Setup<D>& setup, const Faces<D>& faces, const State<D>& state) {
  const auto& p = state.particles;
  std::pair<double, std::string> limit{HUGE_VAL, "nothing that moves"};
  const auto apply = [&](double interval, const std::string& why) {
    if (interval < limit.first) limit = {interval, why};
  };
  // Searches by halving begin at the other limits, or at a time much longer than any run.
  const double ever = 1e12 * std::sqrt(setup.spacing / setup.gravity_or_standard);
  if (state.controlled > 0.0) apply(state.controlled, "pressure change per window");
  limit_by_loads(setup, state.first_interval, state.time, apply);
  for (const auto& l : state.window_limits) apply(l.interval, l.reason);
  // In soil that moves quasi-statically water has no waves, even outside the seepage regime.
  const double slow = quasi_static_speed(setup);
  const auto left = left_soil<D>(setup, state);
  const auto flows = [&](std::size_t a) {
    if (!left.empty() && left[a] != 0) return true;
    return p.in_seepage[a] == 0 && (p.mask[a] <= 0.5 || p.velocity[a].norm() > slow);
  };
  const auto fastest_of = [&](bool flowing) {
    // Like all limits here, of this rank only; finally the least over all ranks is taken.
    return one_rank::max_over(p.size(), 0.0, [&](std::size_t a) {
      return flows(a) == flowing ? p.velocity[a].norm() / spacing_of<D>(p.volume[a]) : 0.0;
    });
  };
  const auto any_is = [&](const auto& what) {
    return !parallel_all(p.size(), [&](std::size_t a) { return !what(a); });
  };
  const bool free_water = any_is(flows);
  const bool free_surface =
      free_water && any_is([&](std::size_t a) { return p.surface[a] != Surface::interior && flows(a); });
  const bool table = any_is([&](std::size_t a) { return p.surface[a] != Surface::interior && !flows(a); });
  double fastest = fastest_of(false);
  const double fastest_free = free_water ? fastest_of(true) : 0.0;
  for (const auto& c : state.columns) fastest = std::max(fastest, std::abs(c.speed) / c.spacing);
  if (fastest > 0.0)
    apply(steps::seepage_courant / fastest, "a quarter spacing per window at the highest speed in soil or at a face");
  if (fastest_free > 0.0)
    apply(steps::free_courant / fastest_free, "two fifths of a spacing per window at the highest speed of free water");
  if (free_surface && setup.weight.norm() > 0.0)
    apply(wave_interval(setup), "gravity waves of one spacing on the free surface");
  // In soil, the water's surface falls at most at the speed under a unit gradient, and at most as fast as a free fall.
  if (table && setup.weight.norm() > 0.0)
    for (const auto& soil : setup.ground.strata()) {
      const double n = soil.porosity, gamma = setup.weight.norm();
      const double fall = porous::resistance(gamma, n, soil.seepage).speed(n * gamma);
      apply(std::max(wave_interval(setup), steps::seepage_courant * setup.spacing / fall),
            "a quarter spacing per window of a water table that falls");
    }
  apply(central_interval(setup), "central force");
  if (free_water)
    // On this rank only, too.
    apply(viscous_interval(setup, one_rank::max_over(p.size(), 0.0, [&](std::size_t a) { return p.wave_speed[a]; })),
          "viscosity");
  limit.first = setup.domain.min(limit.first);  // the searches by halving begin at it
  for (std::size_t f = 0; f < faces.boundaries.size(); ++f)
    if (!faces.is_opening(state, static_cast<int>(f))) {
      const auto bound =
          faces.boundaries[f]->limit(state.time, allowed_change(setup, std::min(limit.first, ever)), state.faces[f]);
      apply(bound.interval, bound.reason);
    }
  for (const auto& inlet : state.inlets) {
    // The longest window in which the inlet's piston moves by at most a quarter spacing, and a rise of the water over
    // the crest is not missed.
    const auto f = static_cast<std::size_t>(inlet.face);
    const auto level_over = [&](double time) { return faces.level(state, inlet.face, time).value() - inlet.lowest; };
    const double over = inlet.sill ? std::max(0.0, level_over(state.time)) : 0.0;
    const double fastest_over =
        std::max(std::abs(inlet.speed), std::sqrt(2.0 / 3.0 * setup.gravity_or_standard * over));
    const auto far = [&](double interval) {
      if (!inlet.sill)
        return std::abs(inlet_speed(*faces.boundaries[f], state.faces[f], inlet, setup.spacing, setup.gravity,
                                    state.time, interval)) *
                   interval >
               steps::seepage_courant * inlet.spacing;
      return fastest_over * interval > steps::seepage_courant * setup.spacing ||
             level_over(state.time + interval) > over + 0.5 * setup.spacing;
    };
    double longest = std::min(limit.first, ever);
    for (int halvings = 0; halvings < 100 && far(longest); ++halvings) longest *= 0.5;
    if (longest < limit.first) apply(longest, "a quarter spacing per window at an inlet");
  }
  // Where a face has no water inside yet, there is no speed to limit the window. The limit is the time in which the
  // front enters by half a spacing.
  if (state.last_interval == 0.0 || !setup.domain.any(p.size() > 0)) {
    ScalarArray water(state.columns.size(), 0.0);
    const ColumnFinder<D> finder(state.columns);
    for (const auto& x : p.position)
      if (const int i = finder.nearest(x); i >= 0) water[static_cast<std::size_t>(i)] = 1.0;
    setup.domain.max(water);
    for (std::size_t i = 0; i < water.size(); ++i) {
      const auto& c = state.columns[i];
      if (!c.wet || water[i] > 0.0) continue;
      const auto speed = infiltration_speed<D>(setup, c);
      const double half = 0.5 * c.spacing;
      if (speed.head > 0.0) apply(0.5 * half * half / speed.head, "first wetting of dry ground");
      if (speed.gravity > 0.0) apply(half / speed.gravity, "first wetting of dry ground");
    }
  }
  return limit;
}

#define PORETWIN_INSTANTIATE(D)                                                                                    \
  template double wave_interval(const Setup<D>&);                                                                  \
  template double quasi_static_speed(const Setup<D>&);                                                             \
  template double free_interval(const Setup<D>&, const Particles<D>&, std::size_t);                                \
  template void begin_control(const Setup<D>&, const SoilView<D>&, double, State<D>&);                             \
  template void control_interval(const Setup<D>&, const ScalarArray&, double, State<D>&);                          \
  template void limit_by_slowing(const Setup<D>&, const VecArray<D>&, double, State<D>&);                          \
  template void limit_by_acceleration(const Setup<D>&, const SoilView<D>&, const VecArray<D>&, double, State<D>&); \
  template void limit_scheme(const Setup<D>&, const SoilView<D>&, State<D>&);                                      \
  template bool load_begins(const Setup<D>&, double);                                                              \
  template std::pair<double, std::string> time_limit(const Setup<D>&, const Faces<D>&, const State<D>&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::fluid
