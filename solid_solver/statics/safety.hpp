// Factor of safety of the soil as it stands at an instant, by strength reduction.
#pragma once

#include "common/coupling/phase.hpp"
#include "common/numerics/border.hpp"
#include "solid_solver/setup.hpp"

#include <optional>
#include <vector>

namespace poretwin::solid {

/// The factor by which cohesion and tan(friction) of all soils can be divided before the soil finds no equilibrium
/// (Griffiths & Lane 1999) under its weight, the loads and the water's forces of this instant, which stay as they are.
/// Every trial starts from the present stress. Nothing where the run is interrupted meanwhile.
template <int D>
std::optional<Border> factor_of_safety(const Setup<D>& setup, const State<D>& state, const BorderSearch& search);

/// Readings of the gauges of kind "factor_of_safety" that are due: the factor, and half the bracket's width. `last`:
/// the factor that was read last, near which the next one is looked for; 0: none yet.
template <int D>
std::vector<GaugeReading> read_factor_of_safety(const Setup<D>& setup, const State<D>& state, double& last);

}  // namespace poretwin::solid
