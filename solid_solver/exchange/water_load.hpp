// The load of the pore water on the soil: its pressure and its drag, given by the fluid or prescribed by the case.
#pragma once

#include "common/coupling/exchange.hpp"
#include "solid_solver/exchange/position_cache.hpp"

namespace poretwin::solid {

/// The fluid's fields for one window at the soil's points: the water's load, and the motion of the soil that the fluid
/// predicts.
template <int D>
struct WaterInput {
  bool tracks = false;       ///< a fluid takes part, and the soil tracks the fluid's prediction
  OrZero<Vec<D>> from, to;   ///< Pa/m, gradient of the pressure at the window's start and end
  OrZero<double> impulse;    ///< N s, impulse of the drag on each particle; components are consecutive
  OrZero<Vec<D>> surplus;    ///< N s, part of the impulse that the fluid did not give and that the water must supply
                             ///< (parallel scheme)
  OrZero<double> predicted;  ///< m/s, velocity of the soil at the window's end that the fluid predicted
  OrZero<double> change;     ///< m/s, change of the predicted velocity in the window
  OrZero<double> soil_seen;  ///< fraction of soil that the fluid reports: 1 inside soil, 0 in free water
  OrZero<double> free_velocity;  ///< m/s, of free water; components are consecutive; only where the soil erodes
  OrZero<double> before;         ///< Pa, pressure of water as a field at the window's start
};

/// Takes the water's fields for a window. Stores pressure, coverage and degree of saturation, and sums the impulse
/// received.
template <int D>
WaterInput<D> take_water(const Setup<D>& setup, const coupling::Inbox& inbox, const coupling::Window& window,
                         PositionCache<D>& cache, State<D>& state);

/// Resets the sums over a window that are for the water: yielding, volumetric strain, and the returned impulse, which
/// begins with the surplus.
template <int D>
void clear_answer(const WaterInput<D>& water, State<D>& state);

/// Pressure [Pa] of the water at the soil's points, from the fluid or, for soil alone, as the case prescribes it.
/// Stores coverage and degree of saturation.
template <int D>
OrZero<double> take_pressure(const Setup<D>& setup, const coupling::Inbox& inbox, double time, PositionCache<D>& cache,
                             State<D>& state);

/// Gradient of a pressure [Pa] at the soil's points [Pa/m]. Below loads that have begun at `time` [s] its form is the
/// one by which stress and pressure share the load.
template <int D>
OrZero<Vec<D>> gradient_of(const Setup<D>& setup, const State<D>& state, const OrZero<double>& pressure, double time);

/// Force [N] of the pore water on particle i: buoyancy -V n_s grad p. If the case prescribes the water, or the water is
/// a field, the force includes the drag.
template <int D>
Vec<D> water_force(const Setup<D>& setup, const State<D>& state, std::size_t i, const Vec<D>& pressure_gradient);

/// The force of the pore water including the drag, which is given as an impulse [N s] over an interval [s].
template <int D>
Vec<D> water_force(const Setup<D>& setup, const State<D>& state, std::size_t i, const Vec<D>& pressure_gradient,
                   const OrZero<double>& impulse, double interval);

/// Buoyancy and drag [N] of water that flows without inertia. By Eq. (27) its drag is n (rho_w g - grad p) per volume
/// for any law of seepage, and the sum of buoyancy and drag is n rho_w g - grad p. For a field it is n S rho_w g -
/// grad(chi p), with the weight of the water that is present (S: its fraction of the pores) and the pressure chi p that
/// the skeleton bears (Bishop 1959).
template <int D>
Vec<D> steady_water_force(const Setup<D>& setup, const State<D>& state, std::size_t i, const Vec<D>& pressure_gradient);

/// Stores the pressure gradient, and the force of pressure and drag, at the end of a window. The published unbalanced
/// force includes this stored force.
template <int D>
void store_water_force(const Setup<D>& setup, const OrZero<Vec<D>>& gradient, const OrZero<double>& impulse,
                       double interval, State<D>& state);

/// Position [m] at which a particle is published to the water. In soil that cannot yield it omits the settlement before
/// time zero, which would move the soil away from its faces: these stay where the case draws them.
template <int D>
Vec<D> reference_position(const Setup<D>& setup, const State<D>& state, std::size_t i) {
  const Vec<D>& x = state.particles.position[i];
  return setup.can_yield ? x : Vec<D>(x - state.rest_displacement[i]);
}

/// Whether a process that starts at `start` [s] has begun at `time` [s], within rounding.
inline bool has_begun(double start, double time) { return time >= start - 1e-9 * std::abs(start); }

/// Number of load patches that have begun.
template <int D>
std::size_t loads_begun(const Setup<D>& setup, double time) {
  return static_cast<std::size_t>(std::count_if(setup.loads.begin(), setup.loads.end(),
                                                [&](const auto& patch) { return has_begun(patch.start, time); }));
}

/// The next time [s] at which a load begins or a prescribed pressure changes its rate; infinite if none follows.
template <int D>
double next_load_after(const Setup<D>& setup, double time);

}  // namespace poretwin::solid
