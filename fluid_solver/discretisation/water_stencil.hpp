// The stencil of the water as it stands: its particles, buffers behind faces and images behind walls.
#pragma once

#include "fluid_solver/boundary/columns.hpp"
#include "fluid_solver/boundary/walls.hpp"

namespace poretwin::fluid {

template <int D>
Stencil<D> water_stencil(const Setup<D>& setup, const Walls<D>& walls, const State<D>& state);

/// Share by which a window of `interval` [s] renews the memory of the rows' thickness.
template <int D>
double share_of_rows(const Setup<D>& setup, double interval);

/// Finds the surface, whose thickness of rows enters `rows` by a share (find_surface).
template <int D>
void mark_surface(const Setup<D>& setup, Stencil<D>& s, std::span<double> rows, double share, State<D>& state);

}  // namespace poretwin::fluid
