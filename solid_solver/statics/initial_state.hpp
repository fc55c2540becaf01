// The soil at time zero: as it was laid, and at rest under gravity, water and standing loads.
#pragma once

#include "solid_solver/exchange/water_load.hpp"
#include "solid_solver/statics/rest.hpp"

namespace poretwin::solid {

/// Particles as they were laid, with their lists and forces; the setup's loads are measured on them.
template <int D>
State<D> laid_out(Setup<D>& setup, Particles<D> particles);

/// Searches for the rest under the water's present pressure; velocities are those of before again.
template <int D>
RestReport come_to_rest(const Setup<D>& setup, State<D>& state);

/// Displacement by uplift, yielding and impulses count from here on.
template <int D>
void start_counting(State<D>& state);

}  // namespace poretwin::solid
