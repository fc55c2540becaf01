// The fluid's gauges: values at points, along lines and faces, sums over regions, the balance of water volume.
#pragma once

#include "common/coupling/phase.hpp"
#include "fluid_solver/boundary/columns.hpp"
#include "fluid_solver/boundary/walls.hpp"

namespace poretwin::fluid {

template <int D>
std::vector<GaugeReading> read_gauges(const Setup<D>& setup, const Faces<D>& faces, const Walls<D>& walls,
                                      const State<D>& state);

/// Adds the impulse of the weight and of the walls in a window of `interval` [s] to State::exchanged.
template <int D>
void count_impulse(const Setup<D>& setup, const Walls<D>& walls, double interval, State<D>& state);

}  // namespace poretwin::fluid
