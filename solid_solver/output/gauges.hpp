// The solid's gauges: what a case may ask of the soil at any time.
#pragma once

#include "common/coupling/phase.hpp"
#include "solid_solver/setup.hpp"

namespace poretwin::solid {

/// Readings of all gauges of the case that belong to the solid. Throws CaseError for a kind or quantity it does not
/// know.
template <int D>
std::vector<GaugeReading> read_gauges(const Setup<D>& setup, const State<D>& state);

}  // namespace poretwin::solid
