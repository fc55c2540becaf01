// A window in which the waves in the soil are followed, in substeps.
#pragma once

#include "common/coupling/exchange.hpp"
#include "solid_solver/exchange/tracking.hpp"

namespace poretwin::solid {

/// Whether a window is one step to an equilibrium or a number of substeps.
template <int D>
CrossedAs way_through(const Setup<D>& setup, const State<D>& state, double interval);

/// Advances the soil by a window in substeps; soil that is quiet at its end falls asleep, and of coupled soil it is
/// decided whether it moves.
template <int D>
void follow_window(const Setup<D>& setup, const coupling::Window& window, std::size_t steps, const WaterInput<D>& water,
                   Tracking<D> tracking, State<D>& state);

}  // namespace poretwin::solid
