// A window in which substeps resolve the waves in the soil.
#pragma once

#include "common/coupling/exchange.hpp"
#include "solid_solver/exchange/tracking.hpp"

namespace poretwin::solid {

/// How a window is computed: as one step to an equilibrium, or in a number of substeps.
template <int D>
CrossedAs way_through(const Setup<D>& setup, const State<D>& state, double interval);

/// Advances the soil by a window in substeps. Soil that is quiet at the window's end falls asleep. Then decides for
/// coupled soil whether the soil moves.
template <int D>
void follow_window(const Setup<D>& setup, const coupling::Window& window, std::size_t steps, const WaterInput<D>& water,
                   Tracking<D> tracking, State<D>& state);

}  // namespace poretwin::solid
