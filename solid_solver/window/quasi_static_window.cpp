#include "solid_solver/window/quasi_static_window.hpp"

#include "common/core/error.hpp"
#include "common/coupling/interrupt.hpp"
#include "common/media/predicted_modulus.hpp"
#include "solid_solver/dynamics/flow_regularisation.hpp"
#include "solid_solver/numerics/sleep.hpp"
#include "solid_solver/numerics/steps.hpp"
#include "solid_solver/statics/equilibrium.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace poretwin::solid {
namespace {

using coupling::Outcome;

/// Upper bound of the plastic shear strain since `before`, in all of the soil except the fraction `sleep::local_share`.
template <int D>
double shear_of_most(const Particles<D>& p, const ScalarArray& before) {
  ScalarArray shear(p.free());
  for (std::size_t i = 0; i < shear.size(); ++i) shear[i] = p.plastic_strain[i] - before[i];
  const auto most =
      shear.begin() + static_cast<std::ptrdiff_t>((1.0 - sleep::local_share) * static_cast<double>(shear.size()));
  std::nth_element(shear.begin(), most, shear.end());
  return most == shear.end() ? 0.0 : *most;
}

/// Fraction to which the soil's motion in a window is drained: 1 in windows longer than the time of consolidation over
/// the soil's height, H^2 gamma_w / (k M); 0 below a fifth of it; linear in between, since creeping soil fails if the
/// fraction changes suddenly. In shorter windows, the soil's dilation sets the pressure of the next window, and this
/// pressure the motion: to extrapolate the motion, or to return all of its impulse immediately, would overshoot.
template <int D>
double drained_fraction(const Setup<D>& setup, const Particles<D>& p, double interval) {
  ScalarArray conductivity;
  for (const Soil& soil : setup.soils)
    conductivity.push_back(seepage_at(setup.water, soil, soil.porosity).conductivity);
  double slowest = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i)
    slowest = std::max(slowest, setup.water.weight / (conductivity[p.material[i]] * moduli(setup, p, i).constrained()));
  constexpr double undrained = steps::undrained;
  const double drained = interval / (setup.height * setup.height * slowest);
  return std::clamp((drained - undrained) / (1.0 - undrained), 0.0, 1.0);
}

/// Rates [1/s] at which the particles' volumes change if the particles have these velocities [m/s].
template <int D>
ScalarArray dilation_of(const Setup<D>& setup, VecArray<D> velocity, State<D>& state) {
  std::swap(state.particles.velocity, velocity);
  fill_velocities(setup, state);
  velocity_gradient<D>(state.near.pairs, state.kernel, state.nodes);
  std::swap(state.particles.velocity, velocity);
  ScalarArray rate(state.particles.size());
  for (std::size_t i = 0; i < rate.size(); ++i) rate[i] = state.nodes[i].gradient.trace();
  return rate;
}

/// Volumetric strain of every particle in a window in which it moves as predicted.
template <int D>
ScalarArray predicted_strain(const Setup<D>& setup, double interval, const Drive<D>& tracking, State<D>& state) {
  VecArray<D> velocity = state.particles.velocity;
  for (std::size_t i = 0; i < velocity.size(); ++i)
    if (tracking.tracking[i] > 0.0) velocity[i] = tracking.target[i];
  ScalarArray strain = dilation_of(setup, std::move(velocity), state);
  for (double& e : strain) e *= interval;
  return strain;
}

/// Root mean square of the ratio of forces on particles [N] to their weights, in soil with water, except for a local
/// part of it.
template <int D>
double over_weight(const Particles<D>& p, const Drive<D>& tracking, std::span<const double> force, double reference) {
  std::vector<std::pair<double, double>> squares;  // each with the particle's mass
  for (std::size_t i = 0; i < p.free(); ++i)
    if (tracking.tracking[i] > 0.0) squares.emplace_back(std::pow(force[i] / (p.mass[i] * reference), 2), p.mass[i]);
  // The search for equilibrium allows a local part of the soil to creep; this part is left out here, too.
  const auto most = squares.size() - static_cast<std::size_t>(sleep::local_share * static_cast<double>(squares.size()));
  if (most < squares.size())
    std::nth_element(squares.begin(), squares.begin() + static_cast<std::ptrdiff_t>(most), squares.end());
  squares.resize(most);
  double sum = 0.0, mass = 0.0;
  for (const auto& [square, m] : squares) {
    sum += m * square;
    mass += m;
  }
  return mass > 0.0 ? std::sqrt(sum / mass) : 0.0;
}

/// Reference acceleration [m/s2] as of reference_acceleration(), to which loads count in full: just after a sudden load
/// on soil full of water, the forces of load and water cancel each other.
template <int D>
double reference_with_loads(const Setup<D>& setup, const State<D>& state, const Drive<D>& drive, double reference) {
  const Particles<D>& p = state.particles;
  for (std::size_t i = 0; i < p.free() && !drive.traction.empty(); ++i)
    reference = std::max(reference, drive.traction[i].norm() / p.mass[i] * setup.spacing / setup.height);
  return setup.domain.max(reference);
}

/// Force that ties the soil to the predicted motion in the first pass of a window, over the weight. Without the part
/// that is inertia of the water; the rest acts on neither phase.
template <int D>
double unborne(const Particles<D>& p, const Tracking<D>& tracking, double reference) {
  const Drive<D>& drive = tracking.drive;
  ScalarArray force(p.size());
  for (std::size_t i = 0; i < p.size(); ++i)
    force[i] = (1.0 - tracking.goes_along[i]) * drive.tracking[i] * (drive.target[i] - p.velocity[i]).norm();
  return over_weight(p, drive, force, reference);
}

/// Force, as the rms of its ratio to the weight, that would bring the soil from its velocity to the predicted one in a
/// repeated window, against inertia and the water's impedance (docs/theory/coupling.md, section 3).
template <int D>
double departure_from(const Setup<D>& setup, double interval, const Tracking<D>& tracking, double reference,
                      State<D>& state) {
  const Particles<D>& p = state.particles;
  const Drive<D>& drive = tracking.drive;
  const double height = setup.height;
  VecArray<D> departure(p.size(), Vec<D>::Zero());
  for (std::size_t i = 0; i < p.size(); ++i)
    if (drive.tracking[i] > 0.0) departure[i] = drive.target[i] - p.velocity[i];
  const ScalarArray dilation = dilation_of(setup, departure, state);
  ScalarArray force(p.size());
  for (std::size_t i = 0; i < p.free(); ++i) {
    if (drive.tracking[i] <= 0.0) continue;
    const WaterAnswer& answer = tracking.answers[i];
    const double translation = p.mass[i] / (p.volume[i] * interval) + std::min(answer.pressure, answer.translation);
    const double pressure = std::max(answer.pressure * height, answer.dilation * interval / height);
    force[i] = p.volume[i] * (translation * departure[i].norm() + pressure * std::abs(dilation[i]));
  }
  return over_weight(p, drive, force, reference);
}

}  // namespace

template <int D>
const Stiffness<D>& QuasiStaticWindow<D>::stiffness_with(const Setup<D>& setup, const ScalarArray& resistance,
                                                         State<D>& state) {
  // The resistance that a window adds matters only if it is not small compared with the stiffness of the slowest mode,
  // c^2 (pi / 2 H)^2 m.
  const Particles<D>& p = state.particles;
  const double slowest = std::pow(0.5 * near_critical_damping(setup), 2);
  ScalarArray& held = state.resistance;
  double change = 0.0, whole = 0.0;
  for (std::size_t i = 0; i < p.free() && !held.empty(); ++i) {
    change += std::abs(resistance[i] - held[i]);
    whole += held[i] + slowest * p.mass[i];
  }
  if (held.empty() || change > statics::still_serves * whole) held = resistance;
  if (!stiffness_ || stiffness_->resistance() != held)
    stiffness_ = std::make_unique<Stiffness<D>>(setup, p, lattice_of(state.erosion), held);
  return *stiffness_;
}

template <int D>
VecArray<D> QuasiStaticWindow<D>::lattice_of(const Eroded& eroded) const {
  if (eroded.first_number.empty()) return lattice_;
  VecArray<D> left;
  for (const Index i : eroded.first_number) left.push_back(lattice_[i]);
  return left;
}

template <int D>
void QuasiStaticWindow<D>::compare_with_prediction(const Setup<D>& setup, double interval, const Tracking<D>& tracking,
                                                   double reference, State<D>& state) {
  if (!setup.coupling.predicts || setup.parallel) return;
  if (!tracking.answers.empty()) {
    unsettled_ = departure_from(setup, interval, tracking, reference, state);
  } else if (const double force = unborne(state.particles, tracking, reference);
             force > setup.coupling.worth_repeating) {
    unsettled_ = force;
  }
  if (setup.coupling.repeats)
    found_ = state.particles.velocity;
  else
    state.motion.held_by_nothing(unsettled_ > 0.0);
}

template <int D>
void QuasiStaticWindow<D>::compare_with_field(const Setup<D>& setup, const coupling::Window& window,
                                              const WaterInput<D>& water, const ScalarArray& volume, double reference,
                                              const State<D>& state) {
  const Particles<D>& p = state.particles;
  if (!setup.coupling.repeats) return;
  const bool again = window.pass > 0;
  ScalarArray strain(p.size());
  double squares = 0.0, mass = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    strain[i] = p.volume[i] / volume[i] - 1.0;
    if (i >= p.free()) continue;
    const double modulus = moduli(setup, p, i).constrained();
    const double predicted = modulus * porous::predicted_modulus(setup.soils[p.material[i]].poissons_ratio, D, again);
    const double foreseen = (again ? found_strain_[i] : 0.0) +
                            (state.external.pressure[i] - (again ? found_pressure_[i] : water.before[i])) / predicted;
    // The pressure that responds to unforeseen strain is a force over the soil's height. It is smaller where water
    // drains.
    const double pores = void_fraction(setup, p, i), height = setup.height;
    const double resistance =
        pores * pores * setup.water.weight / seepage_at(setup.water, setup.soils[p.material[i]], pores).conductivity;
    const double impedance = 1.0 / (1.0 / resistance + height * height / (window.interval * modulus));
    const double force = impedance * height / window.interval * std::abs(strain[i] - foreseen);
    squares += p.mass[i] * std::pow(p.volume[i] * force / (p.mass[i] * reference), 2);
    mass += p.mass[i];
  }
  const double missed = std::sqrt(squares / mass);
  if (again || missed > setup.coupling.worth_repeating) unsettled_ = missed;
  found_strain_ = std::move(strain);
  found_pressure_ = state.external.pressure.values();
  found_pressure_.resize(p.size(), 0.0);
}

template <int D>
typename QuasiStaticWindow<D>::Answer QuasiStaticWindow<D>::advance(const Setup<D>& setup,
                                                                    const coupling::Window& window,
                                                                    const WaterInput<D>& water,
                                                                    const Tracking<D>& tracked, State<D>& state) {
  Particles<D>& p = state.particles;
  const std::size_t n = p.size();
  const double interval = window.interval, end = window.time + interval;
  // With water that has no inertia the soil has none either: its equilibrium does not depend on time.
  const bool inert = !setup.water.is_field;
  const Drive<D>& tracking = tracked.drive;
  const std::vector<WaterAnswer>& answers = tracked.answers;
  const VecArray<D> start = p.displacement, velocity = p.velocity;
  const Vec<D> from_outside = state.from_outside;  // kept, since trial displacements do not count
  const ScalarArray plastic_before = p.plastic_strain;
  VecArray<D> by_water(n);  // N
  // An isotropic stress resists dilation: a modulus times the difference of the volumetric strain from the predicted
  // strain.
  const ScalarArray volume = p.volume;
  const ScalarArray strain_due = answers.empty() ? ScalarArray() : predicted_strain(setup, interval, tracking, state);
  const std::vector<PlateOrder<D>> orders = orders_at(setup.plates, end);
  const std::vector<PlateMotion<D>> plates_before = p.plates;
  if (!setup.plates.empty()) state.external.pressure_gradient = water.to;  // plates bear the pressure at the end
  auto external = [&](Drive<D>& drive, bool rebuilt) {
    if (window.saved) coupling::give_up_if_interrupted();
    drive.plates = orders;
    if (rebuilt && !setup.loads.empty()) drive.traction = load_forces<D>(setup, state, end - 1e-9 * std::abs(end));
    for (std::size_t i = 0; i < n; ++i) {
      const Vec<D> mean = (p.displacement[i] - start[i]) / interval;
      if (!answers.empty()) {
        const double strain = p.volume[i] / volume[i] - 1.0;
        state.backing.set(i, state.external.coverage[i] * answers[i].dilation * (strain - strain_due[i]), n);
      }
      Vec<D> force = by_water[i];
      if (inert) force += p.mass[i] / interval * (velocity[i] - mean);
      force += tracking.tracking[i] * (tracking.target[i] - mean);
      drive.distributed.set(i, force, n);
    }
  };
  for (std::size_t i = 0; i < n; ++i) by_water[i] = water_force(setup, state, i, water.to[i], water.impulse, interval);
  Drive<D> drive;
  external(drive, true);
  if (setup.can_yield) drive.distributed = by_water;
  for (auto& v : p.velocity) v.setZero();
  for (auto& plate : p.plates) {
    plate.velocity.setZero();
    plate.spin = 0.0;
  }
  if (!answers.empty() || !setup.plates.empty()) evaluate_forces(setup, state);
  ScalarArray resistance(p.free());
  // Weak springs for soil without inertia: the preconditioner needs them if no wall fixes the soil.
  const double held = statics::held_by_nothing * near_critical_damping(setup);
  for (std::size_t i = 0; i < p.free(); ++i)
    resistance[i] = inert ? (p.mass[i] / interval + tracking.tracking[i]) / interval : p.mass[i] * held * held;
  const Stiffness<D>& stiffness = stiffness_with(setup, resistance, state);
  const bool asleep = !setup.can_yield
                          ? departure(setup, stiffness, state, drive) <= statics::elastic_error
                          : !softened(setup, state) &&
                                unrest(setup, state, drive, reference_acceleration(setup, state, drive)).largest <=
                                    statics::negligible_unrest;
  const bool pushed =
      plates_move(setup, state, drive, statics::elastic_error, reference_acceleration(setup, state, drive));
  bool moved = false, evaluate = !answers.empty();  // `evaluate`: forces are to be evaluated after the search
  if (!asleep || pushed) {
    const EquilibriumSearch search{
        setup.can_yield ? statics::plastic_error : statics::elastic_share * statics::elastic_error, sleep::local_share,
        statics::woken_by};
    // However short the window is, the search's viscosity acts on velocities over at least the time of a wave.
    const double way = inert ? interval : std::max(interval, long_window(setup));
    RestReport report = find_equilibrium(setup, stiffness, search, way, state, external);
    if (!report.reached() && setup.can_yield) {
      const std::size_t tried = report.steps;
      const RestSearch until{sleep::restless, statics::most_ways, statics::most_ways, sleep::local_share,
                             statics::farthest * setup.spacing};
      // Soil that nothing supports diverges in the search: it is not at rest either.
      try {
        report = find_rest<D>(setup, until, state, external, [](const RestReport&) {});
      } catch (const DivergedError&) {
        report.slides = true;
      }
      report.steps += tried;
    }
    // Creep limited by water reaches an equilibrium in a shorter window, in which there is less creep.
    const double shorter = steps::without_equilibrium * interval;
    if (!report.reached() && shorter > long_window(setup)) {
      fmt::print(stderr, "no equilibrium at t = {:g} s in a window of {:g} s: {} steps, {:.2g} of gravity left\n",
                 window.time, interval, report.steps, report.residual);
      return {Outcome::reject(shorter, "no equilibrium in so long a window"), {.moves = false, .longest = shorter}};
    }
    if (!report.reached() && !inert)
      throw DivergedError(fmt::format(
          "{}: it finds no equilibrium at t = {:g} s in a window of {:g} s, {:.2g} of gravity is left. {}",
          setup.can_yield ? "the soil fails" : "the elastic soil strains too far", window.time, interval,
          report.residual,
          setup.can_yield
              ? "Water as a field has no inertia with which to follow it; what comes now is for fluid.representation = "
                "\"particles\""
              : fmt::format("Expected loads under which it moves by at most {:g} of its height in a window, or stiffer "
                            "soil",
                            statics::farthest_elastic)));
    if (!report.reached()) {
      fmt::print(stderr, "the soil moves at t = {:g} s: no equilibrium in {} steps, {:.2g} of gravity left\n",
                 window.time, report.steps, report.residual);
      return {Outcome::reject(followed_window(setup), "the soil moves: it finds no equilibrium"),
              {.moves = true, .longest = {}}};
    }
    state.sleep.saturation = state.external.saturation;
    moved = report.steps > 0;
    for (std::size_t i = 0; i < n; ++i) state.dilation.set(i, std::log(p.volume[i] / volume[i]));
    if (moved) keep_flow_regular(setup, interval, true, state);
    evaluate = rebuild_if_moved(setup, state) || moved || evaluate;
    state.motion.steps += static_cast<double>(report.steps);
    (moved ? state.motion.relaxed : state.motion.at_rest) += 1.0;
    state.motion.patience = 0.0;
  } else {
    state.motion.at_rest += 1.0;
  }
  state.backing = {};
  if (evaluate) evaluate_forces(setup, state);
  for (std::size_t i = 0; i < n; ++i) {
    p.velocity[i] = (p.displacement[i] - start[i]) / interval;
    if (!asleep || pushed)
      state.returned_impulse.values()[i] +=
          tracked.goes_along[i] * interval * tracking.tracking[i] * (tracking.target[i] - p.velocity[i]);
  }
  if (!p.plates.empty()) check_sound(setup, state, window.time);
  count_pulls(setup, state);
  for (std::size_t k = 0; k < p.plates.size(); ++k) {
    p.plates[k].velocity = (p.plates[k].displacement - plates_before[k].displacement) / interval;
    p.plates[k].spin = (p.plates[k].angle - plates_before[k].angle) / interval;
  }
  // Backward Euler removes the kinetic energy of the change of velocity. This does not matter at velocities below that
  // which a noticeable acceleration causes while a wave passes through the soil and back.
  const double reference = reference_acceleration(setup, state, drive);
  const double slow = statics::woken_by * reference * long_window(setup);
  double work = tracked.dissipated + plastic_work<D>(p, plastic_before);  // and by the work of the stress, added below
  for (std::size_t i = 0; i < p.free() && moved; ++i)
    work += std::abs(p.volume[i] * state.force[i].internal().dot(p.displacement[i] - start[i]));
  if (setup.water.is_field)
    compare_with_field(setup, window, water, volume, reference_with_loads(setup, state, drive, reference), state);
  else
    compare_with_prediction(setup, interval, tracked, reference, state);
  // A departure that is left to the next pass is not a motion of the soil itself.
  const bool settled = answers.empty() || unsettled_ <= setup.coupling.settled_below;
  if (inert && settled && inertia_matters<D>(setup.domain, p, velocity, work, slow))
    return {Outcome::reject(followed_window(setup), "the soil moves: inertia matters"), {.moves = true, .longest = {}}};
  const double by_shear =
      moved ? interval * std::max(steps::shrinks_to, steps::sheared_in_a_window / shear_of_most(p, plastic_before))
            : coupling::no_limit;
  state.motion.longest = std::min(std::max(state.motion.longest, steps::grows_to * interval),
                                  std::max(by_shear, steps::least_by_shear * long_window(setup)));
  state.mean_velocity = p.velocity;
  state.from_outside = from_outside;
  if (setup.counts_impulses) state.from_outside += interval * force_from_outside(setup, state, drive);
  const double drained = drained_fraction(setup, p, interval);
  if (moved && state.any_yielded && drained > 0.0) {
    fill_velocities(setup, state);
    velocity_gradient<D>(state.near.pairs, state.kernel, state.nodes);
    store_plastic_shear_ratio(plastic_before, interval, drained, state);
  }
  store_water_force(setup, water.to, water.impulse, interval, state);
  state.time = end;
  // If nothing has moved, the points keep their revision.
  if (moved || !setup.coupling.keep_points) ++state.revision;
  return {Outcome::accept(), {}};
}

template class QuasiStaticWindow<2>;
template class QuasiStaticWindow<3>;

}  // namespace poretwin::solid
