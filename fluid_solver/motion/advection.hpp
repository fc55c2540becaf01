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

/// Brings a particle that has moved from `before` to x [m] back before the walls that it has passed, and removes its
/// velocity [m/s] into them. spacing: m, of the particle.
template <int D>
void keep_inside(const Walls<D>& walls, const Vec<D>& before, double spacing, Vec<D>& x, Vec<D>& v);

/// Moves free water by half a window of `interval` [s].
template <int D>
void drift(const Setup<D>& setup, const Walls<D>& walls, double interval, Particles<D>& p);

/// Moves all water to the window's end. velocity_before: velocity at the window's start; besides [m]: displacements
/// besides those by the velocity (repair, catch_up), may be empty; gained [n] m^D: volume that comes into each particle
/// in the window (empty: none).
template <int D>
void move(const Setup<D>& setup, const Walls<D>& walls, const Stencil<D>& s, const WindowSolution<D>& solution,
          std::span<const Mat<D>> velocity_gradient, std::span<const Vec<D>> velocity_before,
          std::span<const Vec<D>> besides, std::span<const double> gained, double interval, State<D>& state);

}  // namespace poretwin::fluid
