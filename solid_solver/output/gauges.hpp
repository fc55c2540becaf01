// The solid's gauges: the quantities of the soil that a case may record.
#pragma once

#include "common/coupling/phase.hpp"
#include "solid_solver/setup.hpp"

namespace poretwin::solid {

/// Readings of all gauges of the case that belong to the solid, except factors of safety. Throws CaseError for a kind
/// or quantity that the solid does not have.
template <int D>
std::vector<GaugeReading> read_gauges(const Setup<D>& setup, const State<D>& state);

}  // namespace poretwin::solid
