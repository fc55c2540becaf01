// Factor of safety of the soil as it stands at an instant, by strength reduction.
#pragma once

#include "common/coupling/phase.hpp"
#include "common/numerics/border.hpp"
#include "solid_solver/setup.hpp"

#include <optional>
#include <vector>

namespace poretwin::solid {

struct FactorOfSafety : Border {
  ScalarArray failing_strain;  ///< plastic strain of each particle in the trial that fails nearest to it
};

/// The factor by which cohesion and tan(friction) of all soils can be divided before the soil finds no equilibrium
/// (Griffiths & Lane 1999) under its weight, the loads and the water's forces of this instant, which stay as they are.
/// Every trial starts from the present stress. Nothing where the run is interrupted meanwhile.
template <int D>
std::optional<FactorOfSafety> factor_of_safety(const Setup<D>& setup, const State<D>& state,
                                               const BorderSearch& search);

/// What the gauges of kind "factor_of_safety" read last.
struct SafetyRecord {
  double factor = 0.0;         ///< near which the next one is looked for; 0: none yet
  double time = -1.0;          ///< s
  ScalarArray failing_strain;  ///< see FactorOfSafety
};

/// Readings of the gauges of kind "factor_of_safety" that are due, the first after each multiple of `every`: the
/// factor, and half the bracket's width.
template <int D>
std::vector<GaugeReading> read_factor_of_safety(const Setup<D>& setup, const State<D>& state, SafetyRecord& last);

}  // namespace poretwin::solid
