// Chosen numbers of the exchange of fields with the soil, on the water's side. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

#include <cstddef>

namespace poretwin::fluid::exchange {

/// Difference between the mapped porosity in front of a face and that of the case up to which the case's is used.
/// Unit: 1. Test: Python.AnotherSoilThanTheCaseDrawsIsUsedAtFacesToo (untried).
inline constexpr double same_porosity = 1e-3;
/// Least solid fraction at which a point counts as in soil.
/// Unit: 1. Test: none known.
inline constexpr double least_solid_fraction = 1e-3;

/// Inertia dominates the motion of water in soil where drag needs longer than this time to stop it, a third of the
/// window that a free surface allows. At a spacing of 2 cm it is 4.5 ms, or a drag rate C / (n rho_w) of 220 1/s:
/// rockfill has about 20 1/s, sand (k = 1e-3 m/s, n = 0.4) 3900 1/s.
/// Unit: sqrt(spacing / g). Test: CoarseSoil.ASlabFallsAgainstItsDrag (untried).
inline constexpr double held_within = 0.1;

/// Asymmetry of the soil's points around a place from which on the place lies outside of the soil. On a flat edge the
/// asymmetry is 0.47, in the middle of the ramp from inside to outside.
/// Unit: 1. Test: none known.
inline constexpr double outside_asymmetry = 0.63;
/// Width of the ramp from inside to outside the soil, in terms of the asymmetry. Disorder inside the soil (0.3 at most,
/// for particles anywhere in their cells) then does not change the porosity.
/// Unit: 1. Test: none known.
inline constexpr double ramp_width = 0.32;

/// Smoothing length of the sums (67) and (74) of Bui & Nguyen (2017). Kernel (the cubic spline) and value are theirs.
/// Unit: spacings of the soil. Test: Seepage.SmoothedDragIsAsStrongAsItsKernelSum (untried).
inline constexpr double drag_smoothing_ratio = 1.2;
/// eta^2 of these sums, which keeps the drag between coincident points finite.
/// Unit: h^2. Test: none known.
inline constexpr double drag_softening = 1e-4;

/// In a repeated window a quasi-Newton method extrapolates from the changes between successive passes: largest number
/// of changes that it uses. The reason for the value is not on record.
/// Unit: passes. Test: Passes.ThreeSoftModesAgreeInFiveThoughRepeatedAsTheyAreTheyGrow (untried).
inline constexpr std::size_t most_changes = 8;
/// Least fraction of a change between passes that is linearly independent of the others; smaller ones are rounding
/// errors.
/// Unit: 1. Test: none known.
inline constexpr double independent_change = 1e-6;

/// Averaging time of the difference between the volumetric strain rate that the soil reports and the divergence of its
/// velocity as mapped to the water. In a single window this difference also contains the soil's shortest waves, since
/// the mapping smooths them.
/// Unit: windows. Test: Coupled.PredictsThatSoilClosesWhatItsOwnAccountOpens.
inline constexpr double unseen_strain_windows = 8.0;

}  // namespace poretwin::fluid::exchange
