// Windows in which quiet soil is asleep.
#pragma once

#include "common/coupling/exchange.hpp"
#include "solid_solver/exchange/water_load.hpp"
#include "solid_solver/sleep/quiet.hpp"

namespace poretwin::solid {

/// Leaves the soil asleep during the window if it sleeps and nothing disturbs it; returns whether it does. Sets
/// drive.distributed to the water's forces [N] if the soil was asleep at the window's start.
template <int D>
bool sleeps_on(const Setup<D>& setup, const coupling::Window& window, const WaterInput<D>& water, Drive<D>& drive,
               State<D>& state);

/// Makes the soil fall asleep at the end of a computed window if it is quiet. reference: reference acceleration at the
/// window's start [m/s2].
template <int D>
void fall_asleep_if_quiet(const Setup<D>& setup, const Drive<D>& drive, double reference, State<D>& state);

}  // namespace poretwin::solid
