// Windows that quiet soil passes asleep.
#pragma once

#include "common/coupling/exchange.hpp"
#include "solid_solver/exchange/water_load.hpp"
#include "solid_solver/sleep/quiet.hpp"

namespace poretwin::solid {

/// Passes the window asleep where the soil sleeps and nothing disturbs it; returns whether it does. Sets
/// drive.distributed to the water's forces [N] wherever the soil was asleep.
template <int D>
bool sleeps_on(const Setup<D>& setup, const coupling::Window& window, const WaterInput<D>& water, Drive<D>& drive,
               State<D>& state);

/// Lets the soil fall asleep at the end of a computed window where it is quiet. reference: reference acceleration at
/// the window's start [m/s2].
template <int D>
void fall_asleep_if_quiet(const Setup<D>& setup, const Drive<D>& drive, double reference, State<D>& state);

}  // namespace poretwin::solid
