// Windows that quiet soil passes asleep.
#pragma once

#include "common/coupling/exchange.hpp"
#include "solid_solver/exchange/water_load.hpp"
#include "solid_solver/sleep/quiet.hpp"

namespace poretwin::solid {

/// Passes the window asleep, if the soil is and nothing disturbs it. Otherwise `drive` holds the water's forces.
template <int D>
bool sleeps_on(const Setup<D>& setup, const coupling::Window& window, const WaterInput<D>& water, Drive<D>& drive,
               State<D>& state);

/// At the end of a window that was computed. reference: acceleration at its start [m/s2].
template <int D>
void fall_asleep_if_quiet(const Setup<D>& setup, const Drive<D>& drive, double reference, State<D>& state);

}  // namespace poretwin::solid
