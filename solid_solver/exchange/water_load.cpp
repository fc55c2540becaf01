#include "solid_solver/exchange/water_load.hpp"

#include "common/core/error.hpp"
#include "solid_solver/dynamics/step.hpp"
#include "solid_solver/exchange/field_pressure.hpp"
#include "solid_solver/exchange/pore_water.hpp"
#include "solid_solver/numerics/walls.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace poretwin::solid {
namespace {

using namespace coupling;  // NOLINT: the names of the contract

/// Values of a field at the soil's points; zero if the inbox is empty, as for a solid without a fluid.
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

/// Changes the pressure gradient of the particles below a loaded face to the adjoint form, so that stress and pressure
/// carry the load together. Before that, the pressure of the water beyond the face is subtracted.
template <int D>
void share_load(const Setup<D>& setup, const State<D>& state, const LoadedPatch<D>& patch,
                const OrZero<double>& pressure, double time, VecArray<D>& gradient) {
  // Not done where the soil has moved away from the face: there the fluid predicts a balance that the soil does not
  // have. In coarse, soft soil farther than 0.14 spacings away, the difference grew from window to window.
  double nearest = std::numeric_limits<double>::infinity();
  for (const Index i : patch.particles)
    nearest = std::min(nearest, patch.normal.dot(reference_position(setup, state, i)) - patch.level);
  if (std::abs(nearest - 0.5 * setup.spacing) > walls::moved_off_face * setup.spacing) return;
  ScalarArray excess = pressure.values();
  Vec<D> beyond = Vec<D>::Zero();
  if (patch.water_face) {
    const WaterFace& face = *patch.water_face;
    if (!face.pressure && (!face.head || face.basin_area)) return;
    if (face.head) beyond = setup.water.density * setup.gravity;
    const double datum = face.pressure ? face.pressure->at(time) : beyond.norm() * face.head->at(time);
    for (std::size_t i = 0; i < excess.size(); ++i)
      if (state.external.coverage[i] > 0.0) excess[i] -= datum + beyond.dot(reference_position(setup, state, i));
  }
  pressure_gradient_adjoint<D>(state, excess, patch.particles, gradient);
  for (const Index i : patch.particles) gradient[i] = patch.scale * gradient[i] + beyond;
}

}  // namespace

template <int D>
OrZero<double> take_pressure(const Setup<D>& setup, const Inbox& inbox, double time, PositionCache<D>& cache,
                             State<D>& state) {
  const std::size_t n = state.particles.size();
  OrZero<double>& coverage = state.external.coverage;
  const auto saturate = [&] {
    const auto own = [&]() -> const ScalarArray& { return cache.coverage(setup, state); };
    degree_of_saturation<D>(setup.soils, state, coverage, own, state.external.saturation);
  };
  if (!setup.water.is_prescribed()) {
    coverage = coverage_of(inbox, n);
    OrZero<double> pressure = field_or_zero(inbox, field::pore_pressure, n, 1);
    if (!pressure.is_allocated()) return pressure;
    if (setup.water.is_field) {
      state.external.saturation = field_or_zero(inbox, field::degree_of_saturation, n, 1);
      if (setup.water.has_basins()) state.external.basin_level = field_or_zero(inbox, field::basin_level, n, 1);
      return pressure;
    }
    for (std::size_t i = 0; i < n; ++i)
      if (coverage[i] <= 0.0) pressure.set(i, 0.0);
    saturate();
    return pressure;
  }
  OrZero<double> pressure;
  for (auto* array : {&pressure, &coverage}) array->allocate(n);
  for (std::size_t i = 0; i < n; ++i) {
    Point3 x = Point3::Zero();
    x.head<D>() = state.particles.position[i];
    if (const auto p = prescribed_pressure(setup.water, x, time)) {
      pressure.set(i, *p);
      coverage.set(i, 1.0);
    }
  }
  saturate();
  return pressure;
}

template <int D>
WaterInput<D> take_water(const Setup<D>& setup, const Inbox& inbox, const Window& window, PositionCache<D>& cache,
                         State<D>& state) {
  const std::size_t n = state.particles.size();
  const double interval = window.interval;
  WaterInput<D> water;
  water.tracks = !inbox.fields.empty();
  if (setup.water.is_field) water.before = state.external.pressure;
  state.external.pressure = take_pressure(setup, inbox, window.time + interval, cache, state);
  if (setup.water.is_field) {
    water.from = state.external.pressure_gradient;
    water.to = gradient_of(setup, state, state.external.pressure, window.time + interval);
    state.last_interval = interval;
    return water;
  }
  OrZero<double>& impulse = water.impulse = field_or_zero(inbox, field::drag_impulse, n, D);
  for (std::size_t i = 0; i < n; ++i) {
    state.received += state.returned_impulse[i];
    for (int d = 0; d < D; ++d) state.received[d] += impulse[i * D + static_cast<std::size_t>(d)];
  }
  // In the parallel scheme the soil receives the last window's drag as a constant force. In a window of another length
  // the impulse of this force differs from the impulse that the fluid gave: the water must supply the difference.
  const double beyond = setup.parallel && state.last_interval > 0.0 ? interval / state.last_interval - 1.0 : 0.0;
  state.last_interval = interval;
  if (beyond != 0.0 && impulse.is_allocated()) {
    water.surplus.allocate(n);
    for (std::size_t i = 0; i < n; ++i)
      for (int d = 0; d < D; ++d) water.surplus.values()[i][d] = beyond * impulse[i * D + static_cast<std::size_t>(d)];
    for (double& j : impulse.values()) j *= 1.0 + beyond;
  }
  water.predicted = field_or_zero(inbox, field::predicted_solid_velocity, n, D);
  water.change = field_or_zero(inbox, field::predicted_change, n, D);
  water.soil_seen = field_or_zero(inbox, field::soil_fraction, n, 1);
  if (setup.erodes) water.free_velocity = field_or_zero(inbox, field::free_velocity, n, D);
  state.external.spreading = field_or_zero(inbox, field::spreading_rate, n, 1);

  // The pressure changes linearly in the window, and so does its gradient.
  // The gradient is evaluated once, with the positions at the window's start.
  water.from = state.external.pressure_gradient;
  water.to = gradient_of(setup, state, state.external.pressure, window.time);
  const OrZero<double> at_surface = field_or_zero(inbox, field::surface_share, n, 1);
  const OrZero<double> given_gradient = field_or_zero(inbox, field::surface_gradient, n, D);
  for (std::size_t i = 0; i < n && at_surface.is_allocated(); ++i)
    if (const double share = at_surface[i]; share > 0.0)
      water.to.set(
          i, (1.0 - share) * water.to[i] + share * Eigen::Map<const Vec<D>>(given_gradient.values().data() + i * D), n);
  return water;
}

template <int D>
void clear_answer(const WaterInput<D>& water, State<D>& state) {
  const std::size_t n = water.tracks ? state.particles.size() : 0;
  state.returned_impulse.allocate(n);
  if (water.surplus.is_allocated()) state.returned_impulse = water.surplus;
  std::fill(state.yielded.begin(), state.yielded.end(), char{0});
  state.plastic_shear_ratio.allocate(n);
  state.dilation.allocate(n);
  state.any_yielded = false;
}

template <int D>
OrZero<Vec<D>> gradient_of(const Setup<D>& setup, const State<D>& state, const OrZero<double>& pressure, double time) {
  if (!pressure.is_allocated()) return {};
  if (setup.water.is_field) return gradient_of_field(setup, state, pressure.values(), time);
  VecArray<D> gradient =
      pressure_gradient<D>(state, setup.water.gradient, setup.water.density * setup.gravity, pressure.values());
  for (const auto& patch : setup.loads)
    if (has_begun(patch.start, time)) share_load(setup, state, patch, pressure, time, gradient);
  return gradient;
}

template <int D>
Vec<D> water_force(const Setup<D>& setup, const State<D>& state, std::size_t i, const Vec<D>& pressure_gradient) {
  const Particles<D>& p = state.particles;
  if (setup.water.is_prescribed() || setup.water.is_field)
    return steady_water_force(setup, state, i, pressure_gradient);
  return -p.volume[i] * solid_fraction(setup, p, i) * pressure_gradient;
}

template <int D>
Vec<D> steady_water_force(const Setup<D>& setup, const State<D>& state, std::size_t i,
                          const Vec<D>& pressure_gradient) {
  const Particles<D>& p = state.particles;
  double wet = state.external.coverage[i];  // fraction of the pores filled by water particles
  if (!setup.water.is_prescribed()) {
    const double residual = setup.soils[p.material[i]].initial_saturation;
    wet = residual < 1.0 ? (state.external.saturation[i] - residual) / (1.0 - residual) : 0.0;
  }
  const Vec<D> weight = wet * (1.0 - solid_fraction(setup, p, i)) * setup.water.density * setup.gravity;
  return p.volume[i] * (weight - pressure_gradient);
}

template <int D>
Vec<D> water_force(const Setup<D>& setup, const State<D>& state, std::size_t i, const Vec<D>& pressure_gradient,
                   const OrZero<double>& impulse, double interval) {
  Vec<D> force = water_force(setup, state, i, pressure_gradient);
  for (int d = 0; d < D; ++d) force[d] += impulse[i * D + static_cast<std::size_t>(d)] / interval;
  return force;
}

template <int D>
void store_water_force(const Setup<D>& setup, const OrZero<Vec<D>>& gradient, const OrZero<double>& impulse,
                       double interval, State<D>& state) {
  const Particles<D>& p = state.particles;
  state.external.pressure_gradient = gradient;
  auto& kept = state.external.force;
  kept = {};
  if (setup.water.is_prescribed() || (!gradient.is_allocated() && !impulse.is_allocated())) return;
  kept.allocate(p.size());
  for (std::size_t i = 0; i < p.size(); ++i)
    kept.set(i, water_force(setup, state, i, gradient[i], impulse, interval) / p.volume[i]);
}

template <int D>
double next_load_after(const Setup<D>& setup, double time) {
  double next = next_change_after(setup.water, time);
  for (const auto& patch : setup.loads)
    if (!has_begun(patch.start, time)) next = std::min(next, patch.start);
  for (const auto& plate : setup.plates)
    if (!has_begun(plate.start, time)) next = std::min(next, plate.start);
  return next;
}

#define PORETWIN_INSTANTIATE(D)                                                                                       \
  template OrZero<double> take_pressure<D>(const Setup<D>&, const Inbox&, double, PositionCache<D>&, State<D>&);      \
  template WaterInput<D> take_water<D>(const Setup<D>&, const Inbox&, const Window&, PositionCache<D>&, State<D>&);   \
  template void clear_answer<D>(const WaterInput<D>&, State<D>&);                                                     \
  template OrZero<Vec<D>> gradient_of<D>(const Setup<D>&, const State<D>&, const OrZero<double>&, double);            \
  template Vec<D> water_force<D>(const Setup<D>&, const State<D>&, std::size_t, const Vec<D>&);                       \
  template Vec<D> steady_water_force<D>(const Setup<D>&, const State<D>&, std::size_t, const Vec<D>&);                \
  template Vec<D> water_force<D>(const Setup<D>&, const State<D>&, std::size_t, const Vec<D>&, const OrZero<double>&, \
                                 double);                                                                             \
  template void store_water_force<D>(const Setup<D>&, const OrZero<Vec<D>>&, const OrZero<double>&, double,           \
                                     State<D>&);                                                                      \
  template double next_load_after<D>(const Setup<D>&, double);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::solid
