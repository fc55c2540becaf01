// The pressure that water has before the first window.
#pragma once

#include "fluid_solver/boundary/columns.hpp"
#include "fluid_solver/boundary/walls.hpp"

namespace poretwin::fluid {

/// Pressure of water at rest: no source, no velocity, a skeleton that does not move. Solved as one window as long as a
/// fall through the whole scene, so that inertia is negligible in soil. The seepage speed that this pressure drives
/// bounds the first window; no other speed is known yet. Removes the velocities from the view.
template <int D>
void solve_hydrostatic(const Setup<D>& setup, const Walls<D>& walls, SoilView<D>& view, State<D>& state);

}  // namespace poretwin::fluid
