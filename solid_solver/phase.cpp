#include "solid_solver/phase.hpp"

#include "common/core/error.hpp"
#include "common/coupling/interrupt.hpp"
#include "common/media/seepage.hpp"
#include "solid_solver/dynamics/flow_regularisation.hpp"
#include "solid_solver/exchange/pore_water.hpp"
#include "solid_solver/exchange/saturation.hpp"
#include "solid_solver/numerics/exchange.hpp"
#include "solid_solver/numerics/sleep.hpp"
#include "solid_solver/numerics/statics.hpp"
#include "solid_solver/numerics/steps.hpp"
#include "solid_solver/numerics/walls.hpp"
#include "solid_solver/output/gauges.hpp"
#include "solid_solver/output/readout.hpp"
#include "solid_solver/sleep/regions.hpp"
#include "solid_solver/solid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace poretwin::solid {
namespace {

using namespace coupling;  // NOLINT: the names of the contract

/// Values of a field at the soil's points; zero when the inbox is empty (a solid alone).
OrZero<double> field_or_zero(const Inbox& inbox, std::string_view name, std::size_t n, std::size_t components) {
  if (inbox.coverage.empty() && inbox.fields.empty()) return {};
  const Field& field = inbox.at(name);
  if (field.values.size() != n * components)
    throw PeerError(fmt::format("field '{}': expected {} values ({} soil points of {} components), found {}", name,
                                n * components, n, components, field.values.size()));
  return field.values;
}

OrZero<double> coverage_of(const Inbox& inbox, std::size_t n) {
  if (inbox.coverage.empty()) return {};
  if (inbox.coverage.size() != n)
    throw PeerError(fmt::format("coverage: expected {} values, found {}", n, inbox.coverage.size()));
  ScalarArray coverage = inbox.coverage;
  for (double& c : coverage) c = std::clamp(c, 0.0, 1.0);
  return coverage;
}

/// What all but `sleep::local_share` of the soil has sheared by at most since `before`.
template <int D>
double shear_of_most(const Particles<D>& p, const ScalarArray& before) {
  ScalarArray shear(p.free());
  for (std::size_t i = 0; i < shear.size(); ++i) shear[i] = p.plastic_strain[i] - before[i];
  const auto most =
      shear.begin() + static_cast<std::ptrdiff_t>((1.0 - sleep::local_share) * static_cast<double>(shear.size()));
  std::nth_element(shear.begin(), most, shear.end());
  return most == shear.end() ? 0.0 : *most;
}

/// Loads begin within rounding of their time.
bool has_begun(double start, double time) { return time >= start - 1e-9 * std::abs(start); }

}  // namespace

template <int D>
Solid<D>::Solid(const Case& scene) : scene_(scene) {
  auto [setup, particles] = set_up<D>(scene);
  setup_ = std::move(setup);
  state_.particles = std::move(particles);
  if (scene.coupled()) lattice_ = state_.particles.position;
  const std::size_t n = state_.particles.size();
  state_.body.assign(n, Vec<D>::Zero());
  state_.force.assign(n, {});
  for (std::size_t i = 0; i < n; ++i) {
    const Index soil = state_.particles.material[i];
    const double initial = scene.soils[soil].initial_saturation;
    if (initial > 0.0 || setup_.softened_by_water[soil]) state_.external.saturation.set(i, initial, n);
  }
  state_.yielded.assign(n, 0);
  rebuild(setup_, state_);
  state_.rebuilds = 0.0;
  measure_loads(state_, setup_);
  evaluate_forces(setup_, state_);
}

template <int D>
Contract Solid<D>::contract() const {
  return {D, scene_.digest(), standard_fields(Role::solid, D), standard_fields(Role::fluid, D)};
}

template <int D>
OrZero<Vec<D>> Solid<D>::gradient_of(const OrZero<double>& pressure, double time) const {
  if (!pressure.is_allocated()) return {};
  VecArray<D> gradient = pressure_gradient<D>(state_, scene_.solid.pressure_gradient,
                                              scene_.water.density * setup_.gravity, pressure.values());
  for (const auto& patch : setup_.loads)
    if (has_begun(patch.start, time)) share_load(patch, pressure, time, gradient);
  return gradient;
}

template <int D>
void Solid<D>::share_load(const LoadedPatch<D>& patch, const OrZero<double>& pressure, double time,
                          VecArray<D>& gradient) const {
  // Where the soil has moved away from the face, the water predicts a balance that the soil does not have: in coarse,
  // soft soil what they differ by grew from 0.14 spacings on, in every window.
  double nearest = std::numeric_limits<double>::infinity();
  for (const Index i : patch.particles)
    nearest = std::min(nearest, patch.normal.dot(reference_position(i)) - patch.level);
  if (std::abs(nearest - 0.5 * setup_.spacing) > walls::moved_off_face * setup_.spacing) return;
  ScalarArray excess = pressure.values();
  Vec<D> beyond = Vec<D>::Zero();
  if (patch.water_face) {
    const WaterFace& face = scene_.water_faces[*patch.water_face];
    if (!face.pressure && (!face.head || face.basin_area)) return;
    if (face.head) beyond = scene_.water.density * setup_.gravity;
    const double datum = face.pressure ? face.pressure->at(time) : beyond.norm() * face.head->at(time);
    for (std::size_t i = 0; i < excess.size(); ++i)
      if (state_.external.coverage[i] > 0.0) excess[i] -= datum + beyond.dot(reference_position(i));
  }
  pressure_gradient_adjoint<D>(state_, excess, patch.particles, gradient);
  for (const Index i : patch.particles) gradient[i] = patch.scale * gradient[i] + beyond;
}

/// Soil that cannot yield is published where the case draws it, not below its faces where it settles under its weight.
template <int D>
Vec<D> Solid<D>::reference_position(std::size_t i) const {
  const Vec<D>& x = state_.particles.position[i];
  return setup_.can_yield ? x : Vec<D>(x - state_.rest_displacement[i]);
}

template <int D>
typename Solid<D>::PositionCache& Solid<D>::position_cache() const {
  if (position_cache_.revision != state_.revision) position_cache_ = {state_.revision, {}, {}};
  return position_cache_;
}

template <int D>
const ScalarArray& Solid<D>::covered_by_soil() const {
  auto& coverage = position_cache().coverage;
  if (coverage.empty()) coverage = own_coverage(setup_, state_);
  return coverage;
}

template <int D>
const std::vector<porous::Seepage>& Solid<D>::seepage() const {
  auto& laws = position_cache().seepage;
  const Particles<D>& p = state_.particles;
  for (std::size_t i = laws.size(); i < p.size(); ++i)
    laws.push_back(porous::seepage_at(scene_, scene_.soils[p.material[i]], void_fraction(setup_, p, i)));
  return laws;
}

template <int D>
OrZero<double> Solid<D>::take_pressure(const Inbox& inbox, double time) {
  const std::size_t n = state_.particles.size();
  OrZero<double>& coverage = state_.external.coverage;
  const auto saturate = [&] {
    const auto own = [&]() -> const ScalarArray& { return covered_by_soil(); };
    degree_of_saturation<D>(scene_.soils, state_, coverage, own, state_.external.saturation);
  };
  if (!water_is_prescribed()) {
    coverage = coverage_of(inbox, n);
    OrZero<double> pressure = field_or_zero(inbox, field::pore_pressure, n, 1);
    if (!pressure.is_allocated()) return pressure;
    for (std::size_t i = 0; i < n; ++i)
      if (coverage[i] <= 0.0) pressure.set(i, 0.0);
    saturate();
    return pressure;
  }
  OrZero<double> pressure;
  for (auto* array : {&pressure, &coverage}) array->allocate(n);
  for (std::size_t i = 0; i < n; ++i) {
    Point3 x = Point3::Zero();
    x.head<D>() = state_.particles.position[i];
    if (const auto p = prescribed_pressure(scene_, x, time)) {
      pressure.set(i, *p);
      coverage.set(i, 1.0);
    }
  }
  saturate();
  return pressure;
}

template <int D>
Vec<D> Solid<D>::water_force(std::size_t i, const Vec<D>& pressure_gradient) const {
  const Particles<D>& p = state_.particles;
  if (water_is_prescribed()) return steady_water_force(i, pressure_gradient);
  return -p.volume[i] * solid_fraction(setup_, p, i) * pressure_gradient;
}

template <int D>
Vec<D> Solid<D>::steady_water_force(std::size_t i, const Vec<D>& pressure_gradient) const {
  const Particles<D>& p = state_.particles;
  double wet = state_.external.coverage[i];  // share of the pores
  if (!water_is_prescribed()) {
    const double residual = scene_.soils[p.material[i]].initial_saturation;
    wet = residual < 1.0 ? (state_.external.saturation[i] - residual) / (1.0 - residual) : 0.0;
  }
  const Vec<D> weight = wet * (1.0 - solid_fraction(setup_, p, i)) * scene_.water.density * setup_.gravity;
  return p.volume[i] * (weight - pressure_gradient);
}

template <int D>
Vec<D> Solid<D>::water_force(std::size_t i, const Vec<D>& pressure_gradient, const OrZero<double>& impulse,
                             double interval) const {
  Vec<D> force = water_force(i, pressure_gradient);
  for (int d = 0; d < D; ++d) force[d] += impulse[i * D + static_cast<std::size_t>(d)] / interval;
  return force;
}

template <int D>
void Solid<D>::store_water_force(const OrZero<Vec<D>>& gradient, const OrZero<double>& impulse, double interval) {
  const Particles<D>& p = state_.particles;
  auto& kept = state_.external.force;
  kept = {};
  if (water_is_prescribed() || (!gradient.is_allocated() && !impulse.is_allocated())) return;
  kept.allocate(p.size());
  for (std::size_t i = 0; i < p.size(); ++i) kept.set(i, water_force(i, gradient[i], impulse, interval) / p.volume[i]);
}

template <int D>
double Solid<D>::next_load_after(double time) const {
  double next = next_change_after(scene_, time);
  for (const auto& patch : setup_.loads)
    if (!has_begun(patch.start, time)) next = std::min(next, patch.start);
  return next;
}

template <int D>
void Solid<D>::initialise(const Inbox& inbox) {
  const std::size_t n = state_.particles.size();
  state_.external.pressure = take_pressure(inbox, state_.time);
  if (scene_.solid.initial_rest) {
    const VecArray<D> initial = state_.particles.velocity, slip = state_.particles.slip;
    stop(setup_, state_);
    constexpr double before_everything = -1e300;  // position_cache loads only
    auto external = [&](Drive<D>& drive, bool rebuilt) {
      if (interrupted())
        throw Error(ExitCode::interrupted,
                    "interrupted in the search for the soil's rest: there is nothing to resume from yet");
      if (!rebuilt) return;
      state_.external.pressure_gradient = gradient_of(state_.external.pressure, before_everything);
      drive.traction = load_forces<D>(setup_, state_, before_everything);
      drive.distributed.allocate(n);
      const bool seeps = scene_.solid.initial_seepage && scene_.fluid.drag;
      for (std::size_t i = 0; i < n; ++i) {
        const Vec<D> gradient = state_.external.pressure_gradient[i];
        drive.distributed.set(i, seeps ? steady_water_force(i, gradient) : water_force(i, gradient));
      }
    };
    if (std::any_of(scene_.soils.begin(), scene_.soils.end(),
                    [](const Soil& soil) { return soil.earth_pressure_at_rest.has_value(); })) {
      Drive<D> drive;
      external(drive, true);
      start_from_earth_pressure<D>(setup_, scene_.soils, drive, state_);
    }
    rest_ = find_rest<D>(setup_, {}, state_, external, [](const RestReport& r) {
      fmt::print(stderr,
                 "rest of the soil: largest acceleration {:.2g} of the driving one after {} steps, until {:g}\n",
                 r.residual, r.steps, r.criterion);
    });
    state_.particles.velocity = initial;
    state_.particles.slip = slip;
    position_cache_ = {};
    if (water_is_prescribed()) state_.external.pressure = take_pressure(inbox, state_.time);  // where the soil is now
    rebuild(setup_, state_);
    evaluate_forces(setup_, state_);
  }
  state_.external.pressure_gradient = gradient_of(state_.external.pressure, state_.time);
  store_water_force(state_.external.pressure_gradient, {}, 1.0);
  const auto& moved = state_.particles.displacement;
  if (std::any_of(moved.begin(), moved.end(), [](const Vec<D>& u) { return !u.isZero(0.0); }))
    state_.rest_displacement = moved;
  std::fill(state_.yielded.begin(), state_.yielded.end(), char{0});
  state_.any_yielded = false;
  state_.from_outside.setZero();
  ++state_.revision;
}

template <int D>
std::size_t Solid<D>::loads_begun(double time) const {
  return static_cast<std::size_t>(std::count_if(setup_.loads.begin(), setup_.loads.end(),
                                                [&](const auto& patch) { return has_begun(patch.start, time); }));
}

template <int D>
bool Solid<D>::sleeps_on(Drive<D>& drive, const OrZero<Vec<D>>& gradient, const OrZero<double>& impulse,
                         const Window& window) {
  if (!state_.sleep.asleep) return false;
  const std::size_t n = state_.particles.size();
  drive.distributed.allocate(n);
  for (std::size_t i = 0; i < n; ++i) drive.distributed.set(i, water_force(i, gradient[i], impulse, window.interval));
  const double reference = reference_acceleration(setup_, state_, drive);
  if (disturbed(setup_, state_, drive, loads_begun(window.time), reference, scene_.solid.quiet->wake_above)) {
    state_.sleep.asleep = false;
    return false;
  }
  for (auto* still : {&state_.mean_velocity, &state_.returned_impulse}) *still = {};
  state_.dilation = {};
  state_.external.pressure_gradient = gradient;
  store_water_force(gradient, impulse, window.interval);
  state_.time = window.time + window.interval;
  if (!scene_.coupling.keep_points) ++state_.revision;
  state_.slept += std::ceil(window.interval / setup_.longest_substep - 1e-9);
  return true;
}

template <int D>
void Solid<D>::fall_asleep_if_quiet(const Drive<D>& drive, double reference) {
  const auto& quiet = *scene_.solid.quiet;
  const double rms = unrest(setup_, state_, drive, reference).rms;
  state_.still_yields = state_.any_yielded || (state_.still_yields && rms >= quiet.sleep_below);
  if (state_.any_yielded || rms >= quiet.sleep_below) return;
  stop(setup_, state_);
  state_.sleep = {true, drive.distributed, state_.external.saturation, loads_begun(state_.time)};
}

template <int D>
Outcome Solid<D>::advance(const Window& window, const Inbox& inbox) {
  Particles<D>& p = state_.particles;
  const std::size_t n = p.size();
  const double interval = window.interval;
  if (!(interval > 0.0)) return Outcome::reject(setup_.longest_substep, "a window must be longer than 0 s");

  unsettled_ = 0.0;
  OrZero<double> pressure = take_pressure(inbox, window.time + interval);
  OrZero<double> impulse = field_or_zero(inbox, field::drag_impulse, n, D);
  for (std::size_t i = 0; i < n; ++i) {
    state_.received += state_.returned_impulse[i];
    for (int d = 0; d < D; ++d) state_.received[d] += impulse[i * D + static_cast<std::size_t>(d)];
  }
  // A soil that computes at the same time as the fluid receives the last window's drag as a constant force. In a window
  // of another length the impulse of that force differs from the impulse given; the water has to supply the difference.
  const double beyond = setup_.parallel && state_.last_interval > 0.0 ? interval / state_.last_interval - 1.0 : 0.0;
  state_.last_interval = interval;
  const OrZero<double> given = beyond != 0.0 ? impulse : OrZero<double>();
  if (beyond != 0.0 && impulse.is_allocated())
    for (double& j : impulse.values()) j *= 1.0 + beyond;
  const OrZero<double> predicted = field_or_zero(inbox, field::predicted_solid_velocity, n, D);
  const OrZero<double> change = field_or_zero(inbox, field::predicted_change, n, D);
  const OrZero<double> soil_seen = field_or_zero(inbox, field::soil_fraction, n, 1);

  // The pressure ramps linearly; its gradient is linear in it and taken once, at the window's start.
  const OrZero<Vec<D>> from = state_.external.pressure_gradient;
  OrZero<Vec<D>> to = gradient_of(pressure, window.time);
  const OrZero<double> at_surface = field_or_zero(inbox, field::surface_share, n, 1);
  const OrZero<double> given_gradient = field_or_zero(inbox, field::surface_gradient, n, D);
  for (std::size_t i = 0; i < n && at_surface.is_allocated(); ++i)
    if (const double share = at_surface[i]; share > 0.0)
      to.set(i, (1.0 - share) * to[i] + share * Eigen::Map<const Vec<D>>(given_gradient.values().data() + i * D), n);
  state_.external.pressure = std::move(pressure);

  const bool rests = scene_.coupled() && !state_.motion.moving && interval > followed_window();
  const auto steps =
      rests ? 1
            : std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(interval / setup_.longest_substep - 1e-9)));
  const double dt = interval / static_cast<double>(steps);
  // The water answers to the soil's own motion: where the soil departs from the velocity that the fluid reckoned with,
  // the drag takes the water along while the pressure stays. Backward Euler of (27), the water eliminated, leaves the
  // impedance Z = C a / (a + C), a = n rho_w / Dt, against the departure at the window's end. In the window departures
  // grow linearly; `whole` makes their mean over the substeps the one at the end.
  // In a long window, one step to an equilibrium, what departs meets the drag, C, as if the water stood still: the
  // pressure, which would answer to soil that yields and dilates, is not told of it before the next window. Of that
  // force only the part that is the water's inertia is an impulse of the water; the rest stands for the pressure.
  const double whole = setup_.parallel ? 1.0 : 2.0 * static_cast<double>(steps) / static_cast<double>(steps + 1);
  Drive<D> drive;
  const bool tracks = !inbox.fields.empty();
  double dissipated = 0.0;              // J, by the drag
  VecArray<D> start, change_in_window;  // of the soil's velocity: as it is, and as the fluid reckons
  std::vector<WaterAnswer> answers;     // of windows that are repeated
  ScalarArray goes_along(n, 1.0);       // share of the impedance that is the water's inertia
  if (tracks) {
    drive.tracking.assign(n, 0.0);
    drive.target.assign(n, Vec<D>::Zero());
    if (rests && window.pass > 0) answers.resize(n);
    start = p.velocity;
    change_in_window.assign(n, Vec<D>::Zero());
  }
  for (std::size_t i = 0; i < n && tracks; ++i) {
    if (state_.external.coverage[i] <= 0.0 || soil_seen[i] <= exchange::least_seen) continue;
    const double R = p.mass[i] / p.volume[i];
    double along = 0.0, z = 0.0;  // impedance of the water that goes along; of all that the departure meets
    if (scene_.fluid.drag) {
      const double n_w = void_fraction(setup_, p, i);
      const auto law = porous::resistance(setup_.water_weight, n_w, seepage()[i]);
      const double force = Eigen::Map<const Vec<D>>(impulse.values().data() + i * D).norm() / (p.volume[i] * interval);
      const double slip = law.speed(force), C = law.slope(slip), a = n_w * scene_.water.density / interval;
      dissipated += p.volume[i] * force * slip * interval;
      along = C * a / (a + C);
      // What goes beyond the prediction of the last window, at the same time as the fluid, meets what the pressure
      // would hold against it, too, where water flows back as the grains come, n v_w = -n_s v_s: C / n^2 in all.
      z = setup_.inertia_share > 0.0 ? C / (n_w * n_w) : rests ? C : along;
      if (!answers.empty()) {
        answers[i] =
            answer_of({C, a, n_w, interval}, moduli(setup_, p, i).constrained(), setup_.spacing, setup_.height);
        z = answers[i].translation;
      }
    }
    const double inertia = (answers.empty() && rests ? 0.5 : setup_.inertia_share) * R / interval;
    z += inertia;
    drive.tracking[i] = state_.external.coverage[i] * p.volume[i] * whole * z;
    goes_along[i] = rests && z > 0.0 ? along / z : 1.0;
    for (int d = 0; d < D; ++d) {
      const std::size_t c = i * D + static_cast<std::size_t>(d);
      change_in_window[i][d] = setup_.parallel ? predicted[c] - p.velocity[i][d] : change[c];
      // Inertia holds to the change that is predicted, drag to the velocity.
      if (rests && !setup_.parallel && z > 0.0)
        change_in_window[i][d] = (1.0 - inertia / z) * (predicted[c] - p.velocity[i][d]) + inertia / z * change[c];
      // Where the window is repeated the fluid tells how its prediction differs from what the last pass found.
      if (rests && window.pass > 0) change_in_window[i][d] = found_[i][d] + change[c] - p.velocity[i][d];
    }
    drive.target[i] = p.velocity[i] + change_in_window[i];
  }

  const bool may_sleep = scene_.solid.quiet && !(scene_.coupled() && !setup_.can_yield);
  if (may_sleep && sleeps_on(drive, to, impulse, window)) return Outcome::accept();
  state_.returned_impulse.allocate(tracks ? n : 0);
  for (std::size_t i = 0; i < n && given.is_allocated(); ++i)
    for (int d = 0; d < D; ++d)
      state_.returned_impulse.values()[i][d] = beyond * given[i * D + static_cast<std::size_t>(d)];
  std::fill(state_.yielded.begin(), state_.yielded.end(), char{0});
  state_.plastic_shear_ratio.allocate(tracks ? n : 0);

  state_.dilation.allocate(tracks ? n : 0);
  state_.any_yielded = false;
  if (rests) {
    wake_regions(setup_, state_);
    return advance_at_rest(window, to, impulse, drive, goes_along, answers, dissipated);
  }

  VecArray<D> displacement;
  ScalarArray plastic_before;
  if (tracks) {
    displacement = p.displacement;
    plastic_before = p.plastic_strain;
  }
  double reference = 0.0;

  // The fluid's pressure is the window's mean, which moving soil feels all along; soil that is led from rest to rest
  // takes it as a ramp, unless a load begins with the window and raises it at once.
  bool held = state_.motion.moving;
  for (const auto& patch : setup_.loads)
    held = held || (has_begun(patch.start, window.time) && !has_begun(patch.start, window.time - 0.5 * interval));
  const auto acts = [](double x) { return x != 0.0; };
  const bool dry = std::none_of(impulse.begin(), impulse.end(), acts) &&
                   std::none_of(state_.external.coverage.begin(), state_.external.coverage.end(), acts) &&
                   std::all_of(from.begin(), from.end(), [](const Vec<D>& g) { return g.isZero(0.0); });
  drive.damping_of_calm = setup_.quiet.damping ? near_critical_damping(setup_) : 0.0;
  const bool varies = std::ranges::any_of(setup_.loads, [](const auto& patch) { return patch.factor.has_value(); });
  double loaded_at = -1.0, loaded_rebuilds = -1.0, next_start = -1.0;
  for (std::size_t k = 0; k < steps; ++k) {
    const double now = window.time + static_cast<double>(k) * dt;
    const bool starts = has_begun(next_start, now) && loaded_at >= 0.0;
    if (k == 0 || starts || varies || state_.rebuilds > loaded_rebuilds) {
      if (!setup_.loads.empty()) drive.traction = load_forces<D>(setup_, state_, now + 1e-9 * std::abs(now));
      loaded_at = now;
      loaded_rebuilds = state_.rebuilds;
      next_start = next_load_after(now);
    }
    const double due = static_cast<double>(k + 1) / static_cast<double>(steps);  // share of the window, at its end
    for (std::size_t i = 0; i < n && tracks; ++i)
      drive.target[i] = start[i] + (setup_.parallel ? 1.0 : due) * change_in_window[i];
    const double share = held ? 1.0 : due;
    for (std::size_t i = 0; i < n && !dry; ++i)
      drive.distributed.set(i, water_force(i, (1.0 - share) * from[i] + share * to[i], impulse, interval), n);
    if (may_sleep && k == 0) {
      reference = reference_acceleration(setup_, state_, drive);
      const auto& quiet = *scene_.solid.quiet;
      const bool calm = unrest(setup_, state_, drive, reference).rms < sleep::damped_below * quiet.wake_above;
      drive.damping = quiet.damping && calm && !state_.still_yields ? near_critical_damping(setup_) : 0.0;
      if (drive.damping > 0.0) state_.damped += static_cast<double>(steps);
    }
    substep<D>(setup_, dt, drive, state_);
    watch_regions<D>(setup_, drive, dt, state_);
  }
  check_sound(setup_, state_, window.time);
  state_.external.pressure_gradient = to;
  store_water_force(to, impulse, interval);
  state_.mean_velocity.allocate(tracks ? n : 0);
  for (std::size_t i = 0; i < n && tracks; ++i)
    state_.mean_velocity.set(i, (p.displacement[i] - displacement[i]) / interval);
  if (tracks) store_plastic_shear_ratio(plastic_before, interval, 1.0);
  if (may_sleep) fall_asleep_if_quiet(drive, reference);
  state_.time = window.time + interval;
  state_.substeps += static_cast<double>(steps);
  ++state_.revision;
  if (!scene_.coupled()) return Outcome::accept();
  const double slow = statics::woken_by * reference_acceleration(setup_, state_, drive) / near_critical_damping(setup_);
  const bool hardly_moved =
      share_of_mass(p, [&](std::size_t i) { return p.velocity[i].norm() > slow; }) < sleep::local_share;
  if (tracks) dissipated += plastic_work(plastic_before);
  const bool moves =
      (state_.any_yielded && !hardly_moved) || inertia_matters({}, dissipated * long_window(setup_) / interval, slow);
  if (state_.motion.moving && state_.motion.calms(interval, !moves))
    fmt::print(stderr, "the soil is calm again at t = {:g} s\n", state_.time);
  else if (!state_.motion.moving && moves)
    state_.motion.begins(long_window(setup_));
  return Outcome::accept();
}

template <int D>
double Solid<D>::followed_window() const {
  return (1.0 + 1e-9) * steps::substeps_while_moving * setup_.longest_substep;
}

template <int D>
bool Solid<D>::inertia_matters(std::span<const Vec<D>> before, double dissipated, double slow) const {
  const Particles<D>& p = state_.particles;
  double kinetic = 0.0, creeping = 0.0;
  for (std::size_t i = 0; i < p.free(); ++i) {
    const Vec<D> change = before.empty() ? p.velocity[i] : Vec<D>(p.velocity[i] - before[i]);
    kinetic += 0.5 * p.mass[i] * change.squaredNorm();
    creeping += 0.5 * p.mass[i] * slow * slow;
  }
  return kinetic > steps::noticed * dissipated + creeping;
}

template <int D>
double Solid<D>::plastic_work(std::span<const double> plastic_before) const {
  const Particles<D>& p = state_.particles;
  double work = 0.0;
  for (std::size_t i = 0; i < p.free(); ++i)
    if (const double strain = p.plastic_strain[i] - plastic_before[i]; strain > 0.0)
      work += p.volume[i] * std::numbers::sqrt3 * root_j2(p.stress[i]) * strain;
  return work;
}

template <int D>
double Solid<D>::drained_fraction(double interval) const {
  const Particles<D>& p = state_.particles;
  ScalarArray conductivity;
  for (const Soil& soil : scene_.soils)
    conductivity.push_back(porous::seepage_at(scene_, soil, soil.porosity).conductivity);
  double slowest = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i)
    slowest =
        std::max(slowest, setup_.water_weight / (conductivity[p.material[i]] * moduli(setup_, p, i).constrained()));
  constexpr double undrained = steps::undrained;
  const double drained = interval / (setup_.height * setup_.height * slowest);
  return std::clamp((drained - undrained) / (1.0 - undrained), 0.0, 1.0);
}

template <int D>
void Solid<D>::store_plastic_shear_ratio(std::span<const double> plastic_before, double interval, double factor) {
  const Particles<D>& p = state_.particles;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double plastic = p.plastic_strain[i] - plastic_before[i];
    const double strain = interval * 2.0 / std::numbers::sqrt3 * root_j2(strain_rate<D>(state_.nodes[i].gradient));
    if (plastic > 0.0) state_.plastic_shear_ratio.set(i, factor * (strain > plastic ? plastic / strain : 1.0));
  }
}

template <int D>
ScalarArray Solid<D>::dilation_of(VecArray<D> velocity) {
  std::swap(state_.particles.velocity, velocity);
  fill_velocities<D>(state_.particles, state_.near, state_.nodes);
  velocity_gradient<D>(state_.near.pairs, state_.kernel, state_.nodes);
  std::swap(state_.particles.velocity, velocity);
  ScalarArray rate(state_.particles.size());
  for (std::size_t i = 0; i < rate.size(); ++i) rate[i] = state_.nodes[i].gradient.trace();
  return rate;
}

template <int D>
ScalarArray Solid<D>::predicted_strain(double interval, const Drive<D>& tracking) {
  VecArray<D> velocity = state_.particles.velocity;
  for (std::size_t i = 0; i < velocity.size(); ++i)
    if (tracking.tracking[i] > 0.0) velocity[i] = tracking.target[i];
  ScalarArray strain = dilation_of(std::move(velocity));
  for (double& e : strain) e *= interval;
  return strain;
}

template <int D>
double Solid<D>::over_weight(const Drive<D>& tracking, std::span<const double> force, double reference) const {
  const Particles<D>& p = state_.particles;
  std::vector<std::pair<double, double>> squares;  // and masses
  for (std::size_t i = 0; i < p.free(); ++i)
    if (tracking.tracking[i] > 0.0) squares.emplace_back(std::pow(force[i] / (p.mass[i] * reference), 2), p.mass[i]);
  // Of all but a local part, which the search for equilibrium leaves to creep, too.
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

template <int D>
double Solid<D>::unborne(const Drive<D>& tracking, std::span<const double> goes_along, double reference) const {
  const Particles<D>& p = state_.particles;
  ScalarArray force(p.size());
  for (std::size_t i = 0; i < p.size(); ++i)
    force[i] = (1.0 - goes_along[i]) * tracking.tracking[i] * (tracking.target[i] - p.velocity[i]).norm();
  return over_weight(tracking, force, reference);
}

template <int D>
double Solid<D>::unsettled(double interval, const Drive<D>& tracking, std::span<const WaterAnswer> answers,
                           double reference) {
  const Particles<D>& p = state_.particles;
  const double height = setup_.height;
  VecArray<D> departure(p.size(), Vec<D>::Zero());
  for (std::size_t i = 0; i < p.size(); ++i)
    if (tracking.tracking[i] > 0.0) departure[i] = tracking.target[i] - p.velocity[i];
  const ScalarArray dilation = dilation_of(departure);
  ScalarArray force(p.size());
  for (std::size_t i = 0; i < p.free(); ++i) {
    if (tracking.tracking[i] <= 0.0) continue;
    const WaterAnswer& answer = answers[i];
    const double translation = p.mass[i] / (p.volume[i] * interval) + std::min(answer.pressure, answer.translation);
    const double pressure = std::max(answer.pressure * height, answer.dilation * interval / height);
    force[i] = p.volume[i] * (translation * departure[i].norm() + pressure * std::abs(dilation[i]));
  }
  return over_weight(tracking, force, reference);
}

template <int D>
const Stiffness<D>& Solid<D>::stiffness_with(const ScalarArray& resistance) {
  // What a window adds matters where it is not small against the stiffness of the slowest mode, c^2 (pi / 2 H)^2 m.
  const Particles<D>& p = state_.particles;
  const double slowest = std::pow(0.5 * near_critical_damping(setup_), 2);
  ScalarArray& held = state_.resistance;
  double change = 0.0, whole = 0.0;
  for (std::size_t i = 0; i < p.free() && !held.empty(); ++i) {
    change += std::abs(resistance[i] - held[i]);
    whole += held[i] + slowest * p.mass[i];
  }
  if (held.empty() || change > statics::still_serves * whole) held = resistance;
  if (!stiffness_ || stiffness_->resistance() != held)
    stiffness_ = std::make_unique<Stiffness<D>>(setup_, p, lattice_, held);
  return *stiffness_;
}

template <int D>
Outcome Solid<D>::advance_at_rest(const Window& window, const OrZero<Vec<D>>& gradient, const OrZero<double>& impulse,
                                  const Drive<D>& tracking, std::span<const double> goes_along,
                                  std::span<const WaterAnswer> answers, double dissipated) {
  Particles<D>& p = state_.particles;
  const std::size_t n = p.size();
  const double interval = window.interval, end = window.time + interval;
  const VecArray<D> start = p.displacement, velocity = p.velocity;
  const Vec<D> from_outside = state_.from_outside;  // what the search tries does not count
  const ScalarArray plastic_before = p.plastic_strain;
  VecArray<D> position_cache(n);
  // What holds dilation back: a modulus times what the volume's strain departs by from the predicted one.
  const ScalarArray volume = p.volume;
  const ScalarArray strain_due = answers.empty() ? ScalarArray() : predicted_strain(interval, tracking);
  auto external = [&](Drive<D>& drive, bool rebuilt) {
    if (rebuilt && !setup_.loads.empty()) drive.traction = load_forces<D>(setup_, state_, end - 1e-9 * std::abs(end));
    for (std::size_t i = 0; i < n; ++i) {
      const Vec<D> mean = (p.displacement[i] - start[i]) / interval;
      if (!answers.empty()) {
        const double strain = p.volume[i] / volume[i] - 1.0;
        state_.backing.set(i, state_.external.coverage[i] * answers[i].dilation * (strain - strain_due[i]), n);
      }
      drive.distributed.set(i,
                            position_cache[i] + p.mass[i] / interval * (velocity[i] - mean) +
                                tracking.tracking[i] * (tracking.target[i] - mean),
                            n);
    }
  };
  for (std::size_t i = 0; i < n; ++i) position_cache[i] = water_force(i, gradient[i], impulse, interval);
  Drive<D> drive;
  external(drive, true);
  if (setup_.can_yield) drive.distributed = position_cache;
  for (auto& v : p.velocity) v.setZero();
  if (!answers.empty()) evaluate_forces(setup_, state_);
  ScalarArray resistance(p.free());
  for (std::size_t i = 0; i < p.free(); ++i) resistance[i] = (p.mass[i] / interval + tracking.tracking[i]) / interval;
  const Stiffness<D>& stiffness = stiffness_with(resistance);
  const bool asleep =
      !setup_.can_yield
          ? departure(setup_, stiffness, state_, drive) <= statics::elastic_error
          : !softened(setup_, state_) &&
                unrest(setup_, state_, drive, reference_acceleration(setup_, state_, drive)).largest <= statics::let_be;
  bool moved = false, evaluate = !answers.empty();  // forces, once the search is over
  if (!asleep) {
    const EquilibriumSearch search{
        !setup_.can_yield ? statics::elastic_share * statics::elastic_error : statics::plastic_error,
        sleep::local_share, statics::woken_by};
    RestReport report = find_equilibrium(setup_, stiffness, search, interval, state_, external);
    if (!report.reached() && setup_.can_yield) {
      const std::size_t tried = report.steps;
      const RestSearch until{sleep::restless, statics::most_ways, statics::most_ways, sleep::local_share,
                             statics::farthest * setup_.spacing};
      // Soil that nothing holds runs away in the search: that is no rest either.
      try {
        report = find_rest<D>(setup_, until, state_, external, [](const RestReport&) {});
      } catch (const DivergedError&) {
        report.slides = true;
      }
      report.steps += tried;
    }
    // Creep that water limits finds its equilibrium in a window in which less of it happens.
    const double shorter = steps::without_equilibrium * interval;
    if (!report.reached() && shorter > long_window(setup_)) {
      saved_.motion.longest = shorter;
      fmt::print(stderr, "no equilibrium at t = {:g} s in a window of {:g} s: {} steps, {:.2g} of gravity left\n",
                 window.time, interval, report.steps, report.residual);
      return Outcome::reject(shorter, "no equilibrium in so long a window");
    }
    if (!report.reached()) {
      for (auto* s : {&state_, &saved_}) s->motion.begins(long_window(setup_));
      fmt::print(stderr, "the soil moves at t = {:g} s: no equilibrium in {} steps, {:.2g} of gravity left\n",
                 window.time, report.steps, report.residual);
      return Outcome::reject(followed_window(), "the soil moves: it finds no equilibrium");
    }
    state_.sleep.saturation = state_.external.saturation;
    moved = report.steps > 0;
    for (std::size_t i = 0; i < n; ++i) state_.dilation.set(i, std::log(p.volume[i] / volume[i]));
    if (moved) keep_flow_regular(setup_, interval, true, state_);
    evaluate = rebuild_if_moved(setup_, state_) || moved || evaluate;
    state_.motion.steps += static_cast<double>(report.steps);
    (moved ? state_.motion.relaxed : state_.motion.at_rest) += 1.0;
    state_.motion.patience = 0.0;
  } else {
    state_.motion.at_rest += 1.0;
  }
  state_.backing = {};
  if (evaluate) evaluate_forces(setup_, state_);
  for (std::size_t i = 0; i < n; ++i) {
    p.velocity[i] = (p.displacement[i] - start[i]) / interval;
    if (!asleep)
      state_.returned_impulse.values()[i] +=
          goes_along[i] * interval * tracking.tracking[i] * (tracking.target[i] - p.velocity[i]);
  }
  // Backward Euler takes away the energy of what the velocity changes by: of no account below what a noticeable
  // acceleration gives in the time of a wave.
  const double reference = reference_acceleration(setup_, state_, drive);
  const double slow = statics::woken_by * reference * long_window(setup_);
  double work = dissipated + plastic_work(plastic_before);  // with that of the stress
  for (std::size_t i = 0; i < p.free() && moved; ++i)
    work += std::abs(p.volume[i] * state_.force[i].internal().dot(p.displacement[i] - start[i]));
  if (scene_.predicts() && !setup_.parallel) {
    if (!answers.empty()) {
      unsettled_ = unsettled(interval, tracking, answers, reference);
    } else if (const double force = unborne(tracking, goes_along, reference);
               force > scene_.coupling.tolerance.value_or(steps::worth_repeating)) {
      unsettled_ = force;
    }
    if (repeats_windows())
      found_ = p.velocity;
    else
      state_.motion.held_by_nothing(unsettled_ > 0.0);
  }
  // What a pass leaves to the next one is no motion of the soil's own.
  const bool settled = answers.empty() || unsettled_ <= scene_.coupling.settled_below();
  if (settled && inertia_matters(velocity, work, slow)) {
    for (auto* s : {&state_, &saved_}) s->motion.begins(long_window(setup_));
    return Outcome::reject(followed_window(), "the soil moves: inertia matters");
  }
  const double by_shear =
      moved ? interval * std::max(steps::shrinks_to, steps::sheared_in_a_window / shear_of_most(p, plastic_before))
            : no_limit;
  state_.motion.longest = std::min(std::max(state_.motion.longest, steps::grows_to * interval),
                                   std::max(by_shear, steps::least_by_shear * long_window(setup_)));
  state_.mean_velocity = p.velocity;
  state_.from_outside = from_outside;
  if (setup_.counts_impulses) state_.from_outside += interval * force_from_outside(setup_, state_, drive);
  const double drained = drained_fraction(interval);
  if (moved && state_.any_yielded && drained > 0.0) {
    fill_velocities<D>(p, state_.near, state_.nodes);
    velocity_gradient<D>(state_.near.pairs, state_.kernel, state_.nodes);
    store_plastic_shear_ratio(plastic_before, interval, drained);
  }
  state_.external.pressure_gradient = gradient;
  store_water_force(gradient, impulse, interval);
  state_.time = end;
  // Otherwise the points stand where they stood.
  if (moved || !scene_.coupling.keep_points) ++state_.revision;
  return Outcome::accept();
}

template <int D>
std::pair<double, std::string> Solid<D>::proposal() const {
  std::pair<double, std::string> limit{no_limit, ""};
  const auto apply = [&](double interval, const char* why) {
    if (interval < limit.first) limit = {interval, why};
  };
  apply(next_load_after(state_.time) - state_.time, "the next load begins");
  const double substeps_alone = state_.sleep.asleep ? steps::alone_asleep : steps::alone;
  double alone = scene_.coupled() ? no_limit : substeps_alone * setup_.longest_substep;
  if (!scene_.coupled() && scene_.output.gauge_interval > 0.0) alone = std::min(alone, scene_.output.gauge_interval);
  apply(alone, "soil alone: gauges and prescribed water are seen between windows");
  if ((state_.any_yielded && !scene_.coupled()) || state_.motion.moving) apply(followed_window(), "the soil moves");
  if (!state_.motion.moving) apply(state_.motion.longest, "the soil creeps");
  return limit;
}

template <int D>
Publication Solid<D>::publish() const {
  const Particles<D>& p = state_.particles;
  const auto& images = state_.near.images;
  const std::size_t n = p.size(), all = n + images.size();
  Publication out;
  out.time = state_.time;
  std::tie(out.proposed_interval, out.limited_by) = proposal();
  out.unsettled = unsettled_;
  out.points.dimension = D;
  out.points.revision = state_.revision;
  out.points.n_active = n;
  auto parent = [&](std::size_t i) { return i < n ? i : static_cast<std::size_t>(images[i - n].parent); };
  out.points.position.resize(all * D);
  for (auto* array : {&out.points.volume, &out.points.smoothing_length, &out.points.owner}) array->resize(all);
  for (std::size_t i = 0; i < all; ++i) {
    Eigen::Map<Vec<D>> x(out.points.position.data() + i * D);
    if (i < n)
      x = reference_position(i);
    else
      x = images[i - n].map * reference_position(images[i - n].parent) + images[i - n].shift;
    out.points.volume[i] = p.volume[parent(i)];
    out.points.smoothing_length[i] = setup_.smoothing_length;
    out.points.owner[i] = static_cast<double>(parent(i));
  }
  auto scalars = [&](std::string_view name, auto&& value) {
    Field f{std::string(name), 1, ScalarArray(all)};
    for (std::size_t i = 0; i < all; ++i) f.values[i] = value(parent(i));
    out.fields.push_back(std::move(f));
  };
  auto vectors = [&](std::string_view name, auto&& value) {  // value(i): of point i, ghosts included
    Field f{std::string(name), D, ScalarArray(all * D)};
    for (std::size_t i = 0; i < all; ++i) {
      const Vec<D> v = value(i);
      std::copy(v.data(), v.data() + D, f.values.begin() + static_cast<std::ptrdiff_t>(i * D));
    }
    out.fields.push_back(std::move(f));
  };
  auto moved = [&](const auto& v) {
    return [&](std::size_t i) { return i < n ? v[i] : images[i - n].moved(v[images[i - n].parent], p.slip); };
  };
  vectors(field::solid_velocity, moved(p.velocity));
  vectors(field::mean_solid_velocity, moved(state_.mean_velocity));
  scalars(field::volumetric_strain_rate,
          [&](std::size_t i) { return state_.last_interval > 0.0 ? state_.dilation[i] / state_.last_interval : 0.0; });
  const VecArray<D> load = load_forces<D>(setup_, state_, state_.time + 1e-9 * std::abs(state_.time));
  vectors(field::unbalanced_force, [&](std::size_t i) -> Vec<D> {
    const std::size_t j = parent(i);
    const Vec<D> r =
        state_.force[j].internal() + (load[j] + p.mass[j] * setup_.gravity) / p.volume[j] + state_.external.force[j];
    return i < n ? r : Vec<D>(images[i - n].map * r);
  });
  scalars(field::solid_volume_fraction, [&](std::size_t i) { return solid_fraction(setup_, p, i); });
  scalars(field::grain_density, [&](std::size_t i) { return setup_.grain_density[p.material[i]]; });
  scalars(field::constrained_modulus, [&](std::size_t i) {
    const Elasticity elasticity = moduli(setup_, p, i);
    return state_.yielded[i] ? elasticity.yielding() : elasticity.constrained();
  });
  scalars(field::yielding, [&](std::size_t i) { return state_.plastic_shear_ratio[i]; });
  const auto& seepage = this->seepage();
  scalars(field::hydraulic_conductivity, [&](std::size_t i) { return seepage[i].conductivity; });
  scalars(field::forchheimer_coefficient, [&](std::size_t i) { return seepage[i].quadratic; });
  vectors(field::returned_impulse,
          [&](std::size_t i) { return i < n ? state_.returned_impulse[i] : Vec<D>(Vec<D>::Zero()); });
  return out;
}

template <int D>
OutputFrame Solid<D>::frame() const {
  const Particles<D>& p = state_.particles;
  OutputFrame frame;
  frame.time = state_.time;
  frame.count = p.free();
  frame.position = tell_vectors<D>(p.position);
  const Vec<D> up = upwards(setup_);
  const auto stress = [&p](std::size_t i, double* components) { std::copy_n(p.stress[i].data(), 6, components); };
  const auto add = [&](FieldDeclaration&& declared, TellParticle&& tell) {
    frame.fields.push_back({std::move(declared), std::move(tell)});
  };
  add({"displacement", "m", "displacement of the skeleton since the unloaded state", 3},
      tell_vectors<D>(p.displacement));
  add({"velocity", "m/s", "velocity of the skeleton", 3}, tell_vectors<D>(p.velocity));
  add({"effective_stress", "Pa", "effective stress (xx yy zz xy yz xz), compression negative", 6}, stress);
  add({"pore_pressure", "Pa", "pressure of the water at the soil's points", 1},
      tell_scalars([this](std::size_t i) { return state_.external.pressure[i]; }));
  add({"void_fraction", "1", "porosity n_w = 1 - n_s", 1},
      tell_scalars([&p, this](std::size_t i) { return void_fraction(setup_, p, i); }));
  add({"degree_of_saturation", "1", "water's share of the soil's surroundings, Eq. (90)", 1},
      tell_scalars([this](std::size_t i) { return state_.external.saturation[i]; }));
  add({"accumulated_plastic_strain", "1", "accumulated equivalent deviatoric plastic strain", 1},
      tell_scalars([&p](std::size_t i) { return p.plastic_strain[i]; }));
  add({"mobilised_friction", "degrees", "mobilised friction angle, sin phi_m = (s1 - s3) / (s1 + s3)", 1},
      tell_scalars([&p](std::size_t i) { return mobilised_friction(p.stress[i]); }));
  add({"pore_pressure_ratio", "1", "r_u = pore pressure / total vertical stress; 1: liquefied", 1},
      tell_scalars([&p, this, up](std::size_t i) {
        return pore_pressure_ratio(state_.external.pressure[i], up.dot(matrix_of<D>(p.stress[i]) * up));
      }));
  add({"volume", D == 2 ? "m2" : "m3", "bulk volume that the particle stands for", 1},
      tell_scalars([&p](std::size_t i) { return p.volume[i]; }));
  return frame;
}

template <int D>
std::vector<GaugeReading> Solid<D>::gauges() const {
  return read_gauges<D>(scene_, setup_, state_);
}

template <int D>
std::map<std::string, double> Solid<D>::counters() const {
  return {{"particles", static_cast<double>(state_.particles.size())},
          {"substeps", state_.substeps},
          {"substeps asleep", state_.slept},
          {"substeps damped", state_.damped},
          {"share asleep beside soil that flows",
           state_.regions.watched > 0.0 ? state_.regions.slept / state_.regions.watched : 0.0},
          {"list rebuilds", state_.rebuilds},
          {"windows relaxed", state_.motion.relaxed},
          {"windows at rest", state_.motion.at_rest},
          {"displacements tried", state_.motion.steps},
          {"times the soil began to move", state_.motion.begun},
          {"time in motion", state_.motion.duration},
          {"rest steps", static_cast<double>(rest_.steps)},
          {"rest residual", rest_.residual},
          {"rest displacement", rest_.displacement},
          {"rest criterion", rest_.criterion}};
}

template <int D>
std::vector<Warning> Solid<D>::warnings() const {
  const bool sought = rest_.steps > 0 && !rest_.reached();
  // Soil that ran away in the search starts from a shape that nobody drew. A layer that slides as a whole (cases/
  // sliding_layer: a third of its height) keeps its own.
  const bool far = rest_.displacement > 0.5 * setup_.height;
  return {
      {"the soil's rest was not found", sought ? 1.0 : 0.0,
       fmt::format("{} steps left {:.2g} of the driving acceleration, wanted {:g}; the run starts in motion, the soil "
                   "moved by up to {:.3g} m before time zero: too weak to stand, too soft (youngs_modulus is in "
                   "Pa), or solid.initial_rest = false is meant",
                   rest_.steps, rest_.residual, rest_.criterion, rest_.displacement),
       far},
      {"windows in which a force held the soil that neither phase bears", state_.motion.held,
       "it would have moved otherwise than the water reckoned with; coupling.scheme = \"iterated\" repeats "
       "such windows until both agree",
       true},
      {"times the soil began to move", state_.motion.begun,
       "its inertia matters: it is followed in short windows until it is calm again", false}};
}

template class Solid<2>;
template class Solid<3>;

std::unique_ptr<Phase> make_solid(const Case& scene) {
  if (scene.general.dimension == 3) return std::make_unique<Solid<3>>(scene);
  return std::make_unique<Solid<2>>(scene);
}

}  // namespace poretwin::solid
