// Factor of safety of the soil as it stands at an instant, by strength reduction.
#pragma once

#include "common/coupling/phase.hpp"
#include "common/numerics/border.hpp"
#include "solid_solver/setup.hpp"

#include <optional>
#include <vector>

namespace poretwin::solid {

struct FactorOfSafety : Border {
  ScalarArray failing_strain;  ///< plastic strain of each particle in the failing trial nearest to the factor
};

/// The factor by which cohesion and tan(friction angle) of all soils can be divided until the soil finds no equilibrium
/// (Griffiths & Lane 1999). Weight, loads and the water's forces of this instant act unchanged. Every trial starts from
/// the present stress. Empty where the run is interrupted meanwhile.
template <int D>
std::optional<FactorOfSafety> factor_of_safety(const Setup<D>& setup, const State<D>& state,
                                               const BorderSearch& search);

/// The last reading of the gauges of kind "factor_of_safety".
struct SafetyRecord {
  double factor = 0.0;         ///< first guess for the next reading; 0: none yet
  double time = -1.0;          ///< s
  ScalarArray failing_strain;  ///< see FactorOfSafety
};

/// Readings of the gauges of kind "factor_of_safety" that are due: one after each multiple of the gauge's `every`. Each
/// gives the factor and half the width of its bracket.
template <int D>
std::vector<GaugeReading> read_factor_of_safety(const Setup<D>& setup, const State<D>& state, SafetyRecord& last);

}  // namespace poretwin::solid
