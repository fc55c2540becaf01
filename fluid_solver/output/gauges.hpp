// What is read off the water: values at points, along lines and faces, sums over regions, the balance of its volume.
#pragma once

#include "common/coupling/phase.hpp"
#include "fluid_solver/boundary/columns.hpp"
#include "fluid_solver/boundary/walls.hpp"

namespace poretwin::fluid {

template <int D>
std::vector<GaugeReading> read_gauges(const Setup<D>& setup, const Faces<D>& faces, const Walls<D>& walls,
                                      const State<D>& state);

/// Counts the impulse of a window from weight and walls.
template <int D>
void count_impulse(const Setup<D>& setup, const Walls<D>& walls, double interval, State<D>& state);

}  // namespace poretwin::fluid
