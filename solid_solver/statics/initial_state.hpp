// The soil at time zero: on its initial lattice, and at rest under gravity, water and standing loads.
#pragma once

#include "solid_solver/exchange/water_load.hpp"
#include "solid_solver/statics/rest.hpp"

namespace poretwin::solid {

/// State with the particles on their initial lattice, with pair lists and forces. Sets the scales of the setup's loads.
template <int D>
State<D> laid_out(Setup<D>& setup, Particles<D> particles);

/// Searches for the soil's rest under the present water pressure. Restores the initial velocities at the end.
template <int D>
RestReport come_to_rest(const Setup<D>& setup, State<D>& state);

/// Sets the origin from which uplift, yielding and impulses are counted to the present state.
template <int D>
void start_counting(State<D>& state);

}  // namespace poretwin::solid
