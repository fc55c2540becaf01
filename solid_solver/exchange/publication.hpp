// The points and fields of the soil that the solid publishes to the fluid.
#pragma once

#include "common/coupling/exchange.hpp"
#include "solid_solver/exchange/position_cache.hpp"

namespace poretwin::solid {

/// Points and fields of the present state, images included.
template <int D>
coupling::Publication published(const Setup<D>& setup, const State<D>& state, PositionCache<D>& cache);

}  // namespace poretwin::solid
