// Factor of safety of the soil in its state at one instant, by strength reduction.
#pragma once

#include "common/coupling/phase.hpp"
#include "common/numerics/border.hpp"
#include "solid_solver/setup.hpp"

#include <optional>
#include <vector>

namespace poretwin::solid {

/// The factor of safety, and the failure of the soil in the failing trial nearest to this factor.
template <int D>
struct FactorOfSafety : Border {
  ScalarArray failing_strain;        ///< plastic strain of each free particle in that trial
  VecArray<D> failing_displacement;  ///< m, displacement of each free particle in that trial
};

/// Force of the pore water on the skeleton per volume [N/m3] at particle i. If water and skeleton exchange drag, it is
/// the force of steady flow.
template <int D>
Vec<D> standing_water_force(const Setup<D>& setup, const State<D>& state, std::size_t i);

/// The smallest factor by which cohesion and tan(friction angle) of all soils must be divided for the soil to find no
/// equilibrium (Griffiths & Lane 1999). Weight, loads and `water`, the water's force [N] on each particle, stay
/// unchanged. Every trial starts from the present stress, at rest. The factor depends only on `water` and on the
/// following fields, so that it can be computed from the frames of a finished run: positions, displacements, volumes,
/// stresses, plastic strains, state variables of the materials, saturations, coverage by water, and displacements along
/// frictional walls. Returns nothing if the run is interrupted during the search.
template <int D>
std::optional<FactorOfSafety<D>> factor_of_safety(const Setup<D>& setup, const State<D>& state,
                                                  const VecArray<D>& water, const BorderSearch& search);

/// A search that starts near the last factor that was found. last = 0: no factor was found yet.
BorderSearch search_near(double last, double tolerance);

/// The last reading of the gauges of kind "factor_of_safety".
struct SafetyRecord {
  double factor = 0.0;         ///< first guess for the next reading; 0: no reading yet
  double time = -1.0;          ///< s
  ScalarArray failing_strain;  ///< see FactorOfSafety
};

/// Readings of the gauges of kind "factor_of_safety" that are due: one after each multiple of the gauge's `every`. Each
/// reading contains the factor and half the width of its bracket.
template <int D>
std::vector<GaugeReading> read_factor_of_safety(const Setup<D>& setup, const State<D>& state, SafetyRecord& last);

}  // namespace poretwin::solid
