// The soil at time zero: on its initial lattice, and at rest under gravity, water and the loads that always act.
#pragma once

#include "solid_solver/exchange/water_load.hpp"
#include "solid_solver/statics/rest.hpp"

namespace poretwin::solid {

/// The state with the particles on their initial lattice, with pair lists and forces. Sets the scales of setup.loads.
template <int D>
State<D> laid_out(Setup<D>& setup, Particles<D> particles);

/// Completes a state of the whole soil that has no lists: leaves this rank's share of it, where several ranks share the
/// soil, and makes lists, images and forces. The particles and all that they remember stay as they are.
template <int D>
void complete(const Setup<D>& setup, State<D>& state);

/// Sets the stresses of soils with `earth_pressure_at_rest` to those of level ground under its weight, the permanent loads
/// and the present water pressure (see start_from_earth_pressure); without such soils it does nothing.
template <int D>
void begin_under_earth_pressure(const Setup<D>& setup, State<D>& state);

/// Searches for the soil's rest under the present water pressure, from the stresses of
/// begin_under_earth_pressure. Restores the initial velocities at the end.
template <int D>
RestReport come_to_rest(const Setup<D>& setup, State<D>& state);

/// Sets the present state as the origin from which uplift, yielding and impulses are counted.
template <int D>
void start_counting(State<D>& state);

}  // namespace poretwin::solid
