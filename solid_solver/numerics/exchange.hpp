// Chosen numbers of how the soil sees the water. What an entry needs: CONTRIBUTING.md.
#pragma once

namespace poretwin::solid::exchange {

/// Water's coverage, over the soil's own, that counts as full: the coverage of disordered points scatters by some
/// percent.
/// Unit: 1. Test: Saturation.WaterCountsAgainstTheSoilsOwnShareOfTheSurroundings.
inline constexpr double full_saturation = 0.95;
/// Fraction of soil that the water sees, below which its motion is not followed.
/// Unit: 1. Test: none known.
inline constexpr double least_seen = 1e-6;

/// Length of the surface vector (surface_vectors()) from which on a particle counts as beside a free surface: the first
/// row has 1, disordered points inside some hundredths.
/// Unit: over the spacing. Test: none known.
inline constexpr double surface = 0.02;

}  // namespace poretwin::solid::exchange
