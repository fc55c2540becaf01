// Forces on water besides pressure and drag.
#pragma once

#include "fluid_solver/state.hpp"

namespace poretwin::fluid {

/// Viscosity of free water [m2/s]: that of water, or a numerical viscosity in proportion to the spacing where this is
/// larger. Without it free water is slowly unstable. Explicit sweeps transmit sound and need as much as weakly
/// compressible SPH: alpha h c / (2 (D + 2)) with alpha of at least 0.03 and c = 10 sqrt(g H), H: depth (Monaghan
/// 1994). wave_speed [m/s]: of the longest waves.
template <int D>
double viscosity(const Setup<D>& setup, double wave_speed);

/// Velocities [m/s] after the explicit forces of a window: viscosities of water outside soil, gravity along periodic
/// axes, and the central force. Empty where no such force acts.
template <int D>
VecArray<D> forced_velocity(const Setup<D>& setup, const State<D>& state, const Stencil<D>& s, const SoilView<D>& view,
                            std::span<const Mat<D>> velocity_gradient, double interval);

}  // namespace poretwin::fluid
