// Chosen numbers of how the water sees the soil and answers it. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

#include <cstddef>

namespace poretwin::fluid::exchange {

/// Difference up to which the soil's porosity in front of a face is that of the case, mapped.
/// Unit: 1. Test: Python.AnotherSoilThanTheCaseDrawsIsUsedAtFacesToo (untried).
inline constexpr double same_porosity = 1e-3;
/// Least solid fraction that counts as soil.
/// Unit: 1. Test: none known.
inline constexpr double least_solid_fraction = 1e-3;

/// Time in which drag stops water above which inertia rules in soil: a third of the window that a free surface allows.
/// Rockfill (about 20 1/s) takes longer, sand (150 1/s) never.
/// Unit: sqrt(spacing / g). Test: CoarseSoil.ASlabFallsAgainstItsDrag (untried).
inline constexpr double held_within = 0.1;

/// Asymmetry of the soil's points about a place at which it is no member of the soil any more: 0.47 on a flat edge, and
/// the ramp is even about that.
/// Unit: 1. Test: none known.
inline constexpr double outside_asymmetry = 0.63;
/// Width of that ramp: disorder inside the soil (0.3 at most, for particles anywhere in their cells) does not change
/// the porosity.
/// Unit: 1. Test: none known.
inline constexpr double ramp_width = 0.32;

/// Smoothing length of Eqs. (67)/(74), with the paper's cubic spline: the paper's.
/// Unit: spacings of the soil. Test: Seepage.SmoothedDragIsAsStrongAsItsKernelSum (untried).
inline constexpr double drag_smoothing_ratio = 1.2;
/// eta^2 of Eqs. (67)/(74), which keeps pairs that coincide finite.
/// Unit: h^2. Test: none known.
inline constexpr double drag_softening = 1e-4;

/// Passes of a repeated window whose changes are kept. No reason on record.
/// Unit: passes. Test: Passes.ThreeSoftModesAgreeInFiveThoughRepeatedAsTheyAreTheyGrow (untried).
inline constexpr std::size_t most_changes = 8;
/// Least fraction of such a change that is independent of the others: what is less is rounding.
/// Unit: 1. Test: none known.
inline constexpr double independent_change = 1e-6;

/// Averaging of the strain rate that the water cannot see in the soil's motion: each window also sees the soil's
/// shortest waves, which the mapping smooths.
/// Unit: windows. Test: Coupled.PredictsThatSoilClosesWhatItsOwnAccountOpens.
inline constexpr double unseen_strain_windows = 8.0;

}  // namespace poretwin::fluid::exchange
