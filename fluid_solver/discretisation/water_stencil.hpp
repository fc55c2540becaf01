// The stencil of the water in its present state: particles, buffers behind faces and images behind walls.
#pragma once

#include "fluid_solver/boundary/columns.hpp"
#include "fluid_solver/boundary/walls.hpp"

namespace poretwin::fluid {

template <int D>
Stencil<D> water_stencil(const Setup<D>& setup, const Walls<D>& walls, const State<D>& state);

/// Weight of the rows' present thickness in its average over time, for a window of `interval` [s].
template <int D>
double share_of_rows(const Setup<D>& setup, double interval);

/// Finds the surface (find_surface) and updates the averaged thickness of rows; share: weight of the present thickness.
template <int D>
void mark_surface(const Setup<D>& setup, Stencil<D>& s, std::span<double> rows, double share, State<D>& state);

}  // namespace poretwin::fluid
