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

}  // namespace poretwin::solid::exchange
