// The load of the pore water on the soil: its pressure, taken from the fluid or prescribed by the case, and its drag.
#pragma once

#include "common/coupling/exchange.hpp"
#include "solid_solver/exchange/position_cache.hpp"

namespace poretwin::solid {

/// What the water does to the soil in one window, at its points, and what the fluid says of the soil's motion.
template <int D>
struct WaterInput {
  bool tracks = false;       ///< a fluid is there, whose values are followed
  OrZero<Vec<D>> from, to;   ///< Pa/m, gradient of the pressure at the window's start and end
  OrZero<double> impulse;    ///< N s, of the drag on each particle, components one after the other
  OrZero<Vec<D>> surplus;    ///< N s, part of it that the fluid did not give, so that the water has to supply it
  OrZero<double> predicted;  ///< m/s, velocity of the soil that the fluid predicted, at the window's end
  OrZero<double> change;     ///< m/s, its change in the window
  OrZero<double> soil_seen;  ///< solid fraction that the fluid saw
  OrZero<double> before;     ///< Pa, pressure of a field at the window's start
};

/// Takes the water's fields for a window. Stores pressure, coverage and saturation, and counts the impulse received.
template <int D>
WaterInput<D> take_water(const Setup<D>& setup, const coupling::Inbox& inbox, const coupling::Window& window,
                         PositionCache<D>& cache, State<D>& state);

/// Empties what a window adds up for the water: yielding, dilation and the impulse returned, but for the surplus.
template <int D>
void clear_answer(const WaterInput<D>& water, State<D>& state);

/// Pressure [Pa] of the water at the soil's points, from the partner or, for soil alone, prescribed by the case; stores
/// coverage and saturation.
template <int D>
OrZero<double> take_pressure(const Setup<D>& setup, const coupling::Inbox& inbox, double time, PositionCache<D>& cache,
                             State<D>& state);

/// Gradient of a pressure at the soil's points [Pa/m], with the loads that have begun at `time` [s] shared between
/// stress and pressure.
template <int D>
OrZero<Vec<D>> gradient_of(const Setup<D>& setup, const State<D>& state, const OrZero<double>& pressure, double time);

/// Force [N] of the pore water on particle i: buoyancy -n_s grad p; of water that the case prescribes, or that is a
/// field, also the drag.
template <int D>
Vec<D> water_force(const Setup<D>& setup, const State<D>& state, std::size_t i, const Vec<D>& pressure_gradient);

/// The same with the drag, an impulse [N s] handed over in a window [s].
template <int D>
Vec<D> water_force(const Setup<D>& setup, const State<D>& state, std::size_t i, const Vec<D>& pressure_gradient,
                   const OrZero<double>& impulse, double interval);

/// Buoyancy and drag [N] of water that flows without inertia: by Eq. (27) the drag is then n (rho_w g - grad p),
/// whatever its law, and both are n rho_w g - grad p per volume. Of a field n S rho_w g - grad(chi p): the weight of
/// the water that is there, and the pressure that the skeleton bears (Bishop 1959).
template <int D>
Vec<D> steady_water_force(const Setup<D>& setup, const State<D>& state, std::size_t i, const Vec<D>& pressure_gradient);

/// Stores the gradient and the force of pressure and drag at the end of a window; the published unbalanced force
/// contains that.
template <int D>
void store_water_force(const Setup<D>& setup, const OrZero<Vec<D>>& gradient, const OrZero<double>& impulse,
                       double interval, State<D>& state);

/// Reference position of a particle that is published to the water [m]. Soil that cannot yield is published where the
/// case draws it, not below its faces where it settles under its weight.
template <int D>
Vec<D> reference_position(const Setup<D>& setup, const State<D>& state, std::size_t i) {
  const Vec<D>& x = state.particles.position[i];
  return setup.can_yield ? x : Vec<D>(x - state.rest_displacement[i]);
}

/// Loads begin within rounding of their time [s].
inline bool has_begun(double start, double time) { return time >= start - 1e-9 * std::abs(start); }

/// How many patches of loads have begun.
template <int D>
std::size_t loads_begun(const Setup<D>& setup, double time) {
  return static_cast<std::size_t>(std::count_if(setup.loads.begin(), setup.loads.end(),
                                                [&](const auto& patch) { return has_begun(patch.start, time); }));
}

/// The next time [s] at which a load begins or a prescribed pressure changes its rate; infinite when none does.
template <int D>
double next_load_after(const Setup<D>& setup, double time);

}  // namespace poretwin::solid
