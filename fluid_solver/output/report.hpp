// Output frames, counters and warnings of the fluid.
#pragma once

#include "common/coupling/phase.hpp"
#include "fluid_solver/state.hpp"

namespace poretwin::fluid {

template <int D>
OutputFrame frame_of(const Setup<D>& setup, const State<D>& state);

template <int D>
std::map<std::string, double> counters_of(const Setup<D>& setup, const State<D>& state);

std::vector<Warning> warnings_of(const Counts& c);

}  // namespace poretwin::fluid
