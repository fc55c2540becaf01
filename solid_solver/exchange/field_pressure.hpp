// Force on the soil of pore water that is computed as a field: the gradient of the pressure that the skeleton bears,
// including its change to the pressure beyond the soil's surface.
#pragma once

#include "solid_solver/setup.hpp"
#include "solid_solver/state.hpp"

#include <span>

namespace poretwin::solid {

/// Gradient [Pa/m] of the pressure chi p that the skeleton bears (Bishop's chi), from chi p [Pa] at the particles.
///
/// Inside the soil the gradient consists of differences, exact for linear pressures at any arrangement of the points.
/// At a free surface the total stress is that of the air, or the water behind a face, beyond it. There chi p changes
/// abruptly to that value, above all where it is a suction. Hence the gradient at the surface has the adjoint form of
/// the stress, applied to the difference from the pressure beyond. Thus suction under air compresses the soil, and
/// stress and pressure bear a load on a full column row by row.
template <int D>
VecArray<D> gradient_of_field(const Setup<D>& setup, const State<D>& state, std::span<const double> pressure,
                              double time);

}  // namespace poretwin::solid
