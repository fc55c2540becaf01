// How long the next window may be.
#include "fluid_solver/fluid_phase.hpp"
#include "fluid_solver/numerics/motion.hpp"
#include "fluid_solver/numerics/steps.hpp"
#include "fluid_solver/pressure/eisph.hpp"

#include <cmath>

namespace poretwin::fluid {

/// The shortest window that a change of pressure can require: a fifth of the way of the soil's waves through a spacing.
/// The first one in elastic soil that is wet from the start is a fifth of the time in which a spacing drains where that
/// is longer: before that the water holds the grains and nothing moves but in shear, which the soil refuses so long a
/// window for. Soil that may slide begins to at once.
/// interval [s]: of the window in which soil answers for the first time, 0 before the first.
template <int D>
void Fluid<D>::begin_control(const SoilView<D>& view, double interval) {
  const auto& n = state_.particles.void_fraction;
  const bool yields = scene_.solid.model != SolidCase::Model::elastic;
  double stiffest = 0.0, drains = 0.0;
  for (std::size_t a = 0; a < view.size(); ++a) {
    stiffest = std::max(stiffest, view.modulus[a]);
    if (!yields && view.modulus[a] > 0.0 && view.drag[a] > 0.0)
      drains = std::max(drains, n[a] * n[a] * view.modulus[a] / (view.drag[a] * dx_ * dx_));  // c_v / dx^2
  }
  if (!responds() || stiffest <= 0.0) return;
  first_interval_ = steps::first_wave * dx_ / std::sqrt(stiffest / density_);
  state_.controlled = std::max(first_interval_, interval > 0.0 ? interval
                                                : drains > 0.0 ? steps::first_drained / drains
                                                               : 0.0);
}

/// Next interval from the pressure change of this one; never from a clock.
template <int D>
void Fluid<D>::control_interval(const ScalarArray& before, double interval) {
  const auto& now = state_.particles.pressure;
  if (state_.controlled <= 0.0 || now.empty()) return;
  const auto& x = state_.particles.position;
  double sum = 0.0, lower = now[0], upper = now[0], lightest = weight_.dot(x[0]), heaviest = lightest;
  for (std::size_t a = 0; a < now.size(); ++a) {
    lightest = std::min(lightest, weight_.dot(x[a]));
    heaviest = std::max(heaviest, weight_.dot(x[a]));
    sum += (now[a] - before[a]) * (now[a] - before[a]);
    lower = std::min(lower, now[a]);
    upper = std::max(upper, now[a]);
  }
  for (const auto& c : state_.columns)
    if (c.wet) {
      lower = std::min(lower, c.pressure);
      upper = std::max(upper, c.pressure);
    }
  state_.widest_range = std::max(state_.widest_range, upper - lower);
  // Water at rest has no range of its own: rounding must not shorten its windows.
  // No pressure is resolved better than the weight of one spacing.
  const double range = std::max({upper - lower, steps::widest_share * state_.widest_range,
                                 steps::hydrostatic_share * (heaviest - lightest), weight_.norm() * dx_});
  state_.pressure_change = range > 0.0 ? std::sqrt(sum / static_cast<double>(now.size())) / range : 0.0;
  const double target =
      state_.pressure_change > 0.0 ? interval * steps::wanted_change / state_.pressure_change : HUGE_VAL;
  const double least =
      steps::shrinks_to * std::min(interval, state_.controlled);  // something else may have kept this one short
  state_.controlled = std::max(std::clamp(target, least, steps::grows_to * state_.controlled), first_interval_);
}

/// Limit of the next window where all water seeps: its particles' motion is extrapolated from two windows.
/// Noise of single particles, which is no slowing, cancels in the sum.
template <int D>
void Fluid<D>::limit_by_slowing(const VecArray<D>& velocity_before, double interval) {
  state_.window_limits.clear();
  const auto& p = state_.particles;
  if (scene_.coupled() || scene_.fluid.scheme != FluidCase::Scheme::projection ||
      !parallel_all(p.size(), [&](std::size_t a) { return p.in_seepage[a] != 0; }))
    return;
  const auto open = [](const FaceColumn<D>& c) { return c.in_soil && !c.wet; };
  if (std::any_of(state_.columns.begin(), state_.columns.end(), open)) {
    const ColumnFinder<D> finder(state_.columns);
    const double fastest = parallel_max(p.size(), 0.0, [&](std::size_t a) {
      const int i = p.surface[a] == Surface::interior ? -1 : finder.nearest(p.position[a]);
      if (i < 0) return 0.0;
      const auto& c = state_.columns[static_cast<std::size_t>(i)];
      return open(c) ? -c.normal.dot(p.velocity[a]) / c.spacing : 0.0;
    });
    if (fastest > 0.0)
      state_.window_limits.push_back({steps::wanted_exit / fastest,
                                      "an eighth of a spacing per window of water that leaves through a seepage face"});
  }
  const double change = sum_over(
      p.size(), [&](std::size_t a) { return p.mass[a] * p.velocity[a].dot(p.velocity[a] - velocity_before[a]); });
  if (change == 0.0) return;
  const double whole = sum_over(p.size(), [&](std::size_t a) { return p.mass[a] * p.velocity[a].squaredNorm(); });
  const double mass = sum_over(p.size(), [&](std::size_t a) { return p.mass[a]; });
  const double altered = interval * std::abs(change) / std::sqrt(whole * mass) / dx_;
  state_.window_limits.push_back(
      {interval * std::max(0.5, std::sqrt(steps::wanted_slowing / altered)), "seepage that slows down"});
}

/// Limit of the next window by water in coarse soil, which inertia dominates: it moves by no more than a quarter
/// spacing at its speed and the acceleration of the last window. When it has just been stopped, by the base or by the
/// surface that has come down on it, its speed alone says nothing of the next window.
template <int D>
void Fluid<D>::limit_by_acceleration(const SoilView<D>& view, const VecArray<D>& velocity_before, double interval) {
  const auto& p = state_.particles;
  const auto in_coarse = [&](std::size_t a) {
    return p.in_seepage[a] != 0 && view.mask[a] > 0.5 && !is_drag_dominated(view, a);
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
  if (std::isfinite(longest))
    state_.window_limits.push_back({longest, "a quarter spacing per window of water in coarse soil that accelerates"});
}

/// Limit of the next window by an explicit scheme, for the present water and soil.
template <int D>
void Fluid<D>::limit_scheme(const SoilView<D>& view) {
  const auto& p = state_.particles;
  if (scene_.fluid.scheme == FluidCase::Scheme::projection) return;
  double pressure = 0.0, fastest = 0.0;
  for (std::size_t a = 0; a < p.size(); ++a) {
    pressure = std::max(pressure, p.pressure[a] + weight_.dot(p.position[a] - origin_));
    fastest = std::max(fastest, p.velocity[a].norm());
  }
  for (const auto& c : state_.columns)
    if (c.wet) pressure = std::max(pressure, c.pressure + weight_.dot(c.foot - origin_));
  pressure = std::max(pressure, density_ * fastest * fastest);
  double sweep = HUGE_VAL, drag = HUGE_VAL, skeleton = HUGE_VAL;
  const bool implicit_drag = scene_.fluid.scheme != FluidCase::Scheme::eisph_explicit_drag;
  for (std::size_t a = 0; a < p.size(); ++a) {
    const double n = p.void_fraction[a], C = view.drag[a];
    sweep = std::min(sweep, sweep_interval<D>(n, implicit_drag ? C : 0.0, density_, pressure,
                                              spacing_of<D>(p.volume[a]), scene_.fluid.sweeps));
    if (C <= 0.0) continue;
    drag = std::min(drag, n * density_ / C);
    if (scene_.coupled()) skeleton = std::min(skeleton, view.density[a] * n * n / C);
  }
  state_.window_limits.push_back({sweep, "compression under explicit sweeps"});
  if (!implicit_drag) state_.window_limits.push_back({drag, "explicit drag"});
  state_.window_limits.push_back({skeleton, "a skeleton that does not respond inside the window"});
}

/// Longest window in which gravity waves of one spacing on a free surface are followed [s].
template <int D>
double Fluid<D>::wave_interval() const {
  return weight_.norm() > 0.0 ? steps::wave_courant * std::sqrt(dx_ * density_ / weight_.norm()) : HUGE_VAL;
}

/// Speed below which soil and the water in it are as good as at rest: a hundredth of what gravity gives in the window
/// of the shortest waves [m/s].
template <int D>
double Fluid<D>::quasi_static_speed() const {
  return weight_.norm() > 0.0 ? steps::quasi_static * wave_interval() * weight_.norm() / density_ : HUGE_VAL;
}

/// Longest window in which particles follow the central force [s].
template <int D>
double Fluid<D>::central_interval() const {
  const double force = scene_.general.central_force;
  return force > 0.0 ? steps::central_courant / std::sqrt(force) : HUGE_VAL;
}

/// Longest window in which the viscosities of free water are stable [s].
template <int D>
double Fluid<D>::viscous_interval() const {
  const double viscosity = this->viscosity() + motion::noise_viscosity * dx_ * state_.wave_speed;
  return viscosity > 0.0 ? steps::viscous_courant * dx_ * dx_ / viscosity : HUGE_VAL;
}

/// Longest window that the motion of free water allows [s].
template <int D>
double Fluid<D>::free_interval() const {
  const auto& p = state_.particles;
  const double longest = -parallel_max(p.size(), -HUGE_VAL, [&](std::size_t a) {
    if (p.in_seepage[a] != 0) return -HUGE_VAL;
    return -(steps::free_courant * spacing_of<D>(p.volume[a]) / std::max(p.velocity[a].norm(), 1e-300));
  });
  return std::min({wave_interval(), central_interval(), viscous_interval(), longest});
}

/// What may change behind a face or in a load in one window, however slow the water is: no more than by half a spacing
/// of water, but windows need not be shorter than a fall through a spacing, which nothing that seeps follows.
template <int D>
AllowedChange Fluid<D>::allowed_change(double longest) const {
  const double rise = steps::wanted_rise * dx_;
  return {rise, rise * density_ * gravity_or_standard_, steps::least_for_tables * std::sqrt(dx_ / gravity_or_standard_),
          longest};
}

/// What tables of loads ask of the window from `now` on. Where soil responds, a load that begins is followed from its
/// first wave on.
template <int D>
void Fluid<D>::limit_by_loads(double now, const std::function<void(double, const std::string&)>& apply) const {
  if (!scene_.coupled()) return;
  const auto allowed = allowed_change(HUGE_VAL);
  for (const auto& load : scene_.loads)
    if (load.factor && load.traction.norm() > 0.0)
      apply(std::max(allowed.shortest, unchanged_for(*load.factor, now, allowed.pressure / load.traction.norm())),
            "a load that changes");
  if (first_interval_ > 0.0 && load_begins(now)) apply(first_interval_, "a load that begins");
}

/// Whether a load begins at a time, to rounding.
template <int D>
bool Fluid<D>::load_begins(double time) const {
  return std::any_of(scene_.loads.begin(), scene_.loads.end(), [&](const Load& load) {
    return load.start && *load.start > 0.0 && std::abs(time - *load.start) <= 1e-9 * *load.start;
  });
}

template <int D>
std::pair<double, std::string> Fluid<D>::time_limit() const {
  const auto& p = state_.particles;
  std::pair<double, std::string> limit{HUGE_VAL, "nothing that moves"};
  const auto apply = [&](double interval, const std::string& why) {
    if (interval < limit.first) limit = {interval, why};
  };
  // What is found by halving begins with the other limits, or with far more than any run takes.
  const double ever = 1e12 * std::sqrt(dx_ / gravity_or_standard_);
  if (state_.controlled > 0.0) apply(state_.controlled, "pressure change per window");
  limit_by_loads(state_.time, apply);
  for (const auto& l : state_.window_limits) apply(l.interval, l.reason);
  // In soil that moves quasi-statically water has no waves, even where it is not in the seepage regime.
  const double slow = quasi_static_speed();
  const auto flows = [&](std::size_t a) {
    return p.in_seepage[a] == 0 && (p.mask[a] <= 0.5 || p.velocity[a].norm() > slow);
  };
  const auto fastest_of = [&](bool flowing) {
    return parallel_max(p.size(), 0.0, [&](std::size_t a) {
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
  for (const auto& c : state_.columns) fastest = std::max(fastest, std::abs(c.speed) / c.spacing);
  if (fastest > 0.0)
    apply(steps::seepage_courant / fastest, "a quarter spacing per window at the highest speed in soil or at a face");
  if (fastest_free > 0.0)
    apply(steps::free_courant / fastest_free, "two fifths of a spacing per window at the highest speed of free water");
  if (free_surface && weight_.norm() > 0.0) apply(wave_interval(), "gravity waves of one spacing on the free surface");
  // In soil the surface falls no faster than under a unit gradient, nor than freely.
  if (table && weight_.norm() > 0.0)
    for (const auto& soil : ground_.strata()) {
      const double n = soil.porosity, gamma = weight_.norm();
      const double fall = porous::resistance(gamma, n, soil.seepage).speed(n * gamma);
      apply(std::max(wave_interval(), steps::seepage_courant * dx_ / fall),
            "a quarter spacing per window of a water table that falls");
    }
  apply(central_interval(), "central force");
  if (free_water) apply(viscous_interval(), "viscosity");
  for (std::size_t f = 0; f < boundaries_.size(); ++f)
    if (!is_opening(static_cast<int>(f))) {
      const auto bound =
          boundaries_[f]->limit(state_.time, allowed_change(std::min(limit.first, ever)), state_.faces[f]);
      apply(bound.interval, bound.reason);
    }
  for (const auto& inlet : state_.inlets) {
    // The longest window in which its piston moves by a quarter spacing at most; no crest is passed unawares.
    const auto f = static_cast<std::size_t>(inlet.face);
    const auto level_over = [&](double time) { return level_behind(inlet.face, time).value() - inlet.lowest; };
    const double over = inlet.sill ? std::max(0.0, level_over(state_.time)) : 0.0;
    const double fastest_over = std::max(std::abs(inlet.speed), std::sqrt(2.0 / 3.0 * gravity_or_standard_ * over));
    const auto far = [&](double interval) {
      if (!inlet.sill)
        return std::abs(inlet_speed(*boundaries_[f], state_.faces[f], inlet, dx_, scene_.general.gravity.norm(),
                                    state_.time, interval)) *
                   interval >
               steps::seepage_courant * inlet.spacing;
      return fastest_over * interval > steps::seepage_courant * dx_ ||
             level_over(state_.time + interval) > over + 0.5 * dx_;
    };
    double longest = std::min(limit.first, ever);
    for (int halvings = 0; halvings < 100 && far(longest); ++halvings) longest *= 0.5;
    if (longest < limit.first) apply(longest, "a quarter spacing per window at an inlet");
  }
  // A face without water inside it yet has no speed to limit the window: the time in which the front comes half a
  // spacing in.
  if (p.size() == 0 || state_.last_interval == 0.0) {
    std::vector<char> water(state_.columns.size(), 0);
    const ColumnFinder<D> finder(state_.columns);
    for (const auto& x : p.position)
      if (const int i = finder.nearest(x); i >= 0) water[static_cast<std::size_t>(i)] = 1;
    for (std::size_t i = 0; i < water.size(); ++i) {
      const auto& c = state_.columns[i];
      if (!c.wet || water[i]) continue;
      const auto speed = infiltration_speed(c);
      const double half = 0.5 * c.spacing;
      if (speed.head > 0.0) apply(0.5 * half * half / speed.head, "first wetting of dry ground");
      if (speed.gravity > 0.0) apply(half / speed.gravity, "first wetting of dry ground");
    }
  }
  return limit;
}

template class Fluid<2>;
template class Fluid<3>;

}  // namespace poretwin::fluid
