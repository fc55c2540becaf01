// Motion of the water's particles through one window, within the walls.
#pragma once

#include "fluid_solver/boundary/walls.hpp"
#include "fluid_solver/pressure/window.hpp"
#include "fluid_solver/state.hpp"

namespace poretwin::fluid {

/// Factor on the last change of velocity with which the motion of seeping water is extrapolated to the middle of the
/// window (Adams-Bashforth, second order). The velocity of seepage follows from the geometry, and the window's velocity
/// belongs to the geometry at its start. Intervals [s].
inline double look_ahead(double last_interval, double interval) {
  return last_interval > 0.0 ? std::min(1.0, 0.5 * interval / last_interval) : 0.0;
}

/// Moves free water by half a window of `interval` [s].
template <int D>
void drift(const Setup<D>& setup, const Walls<D>& walls, double interval, Particles<D>& p);

/// Moves all water to the window's end. velocity_before: velocity at the window's start; repair [m]: displacements that
/// repair() returns.
template <int D>
void move(const Setup<D>& setup, const Walls<D>& walls, const Stencil<D>& s, const WindowSolution<D>& solution,
          std::span<const Mat<D>> velocity_gradient, std::span<const Vec<D>> velocity_before,
          std::span<const Vec<D>> repair, double interval, State<D>& state);

}  // namespace poretwin::fluid
