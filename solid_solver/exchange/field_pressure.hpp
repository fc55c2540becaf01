// What pore water that is a field does to the soil: the pressure that the skeleton bears, against what stands beyond
// the soil's surface.
#pragma once

#include "solid_solver/setup.hpp"
#include "solid_solver/state.hpp"

#include <span>

namespace poretwin::solid {

/// Gradient [Pa/m] of the pressure chi p that the skeleton bears.
///
/// At a free surface the total stress is that of what lies beyond: air, or the water behind a face. There chi p,
/// suction above all, falls to it at once, and the gradient takes the adjoint form that the stress has, of the pressure
/// over that beyond: suction under air compresses the soil, and a load on a full column is borne by stress and pressure
/// row by row. Inside it is that of differences, exact for linear pressures however the points lie.
template <int D>
VecArray<D> gradient_of_field(const Setup<D>& setup, const State<D>& state, std::span<const double> pressure,
                              double time);

}  // namespace poretwin::solid
