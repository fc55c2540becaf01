// The pressure of the water before the first window.
#pragma once

#include "fluid_solver/boundary/columns.hpp"
#include "fluid_solver/boundary/walls.hpp"

namespace poretwin::fluid {

/// Computes the pressure of water at rest: without sources and velocities, and with a fixed skeleton. It is solved as
/// one window as long as a fall through the whole scene, so that inertia is negligible in soil. This pressure gives a
/// speed of seepage, which limits the first window, since no other speed is known yet. Removes the velocities from the
/// view.
template <int D>
void solve_hydrostatic(const Setup<D>& setup, const Walls<D>& walls, SoilView<D>& view, State<D>& state);

}  // namespace poretwin::fluid
