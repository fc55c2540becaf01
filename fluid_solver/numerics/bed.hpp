// Chosen numbers of the bed through which water passes between particles and the ground. What an entry needs:
// CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::fluid::bed {

/// Smoothing length of the weights by which a part of the bed and the particles before it exchange water. The support,
/// twice this length, contains four rows. With half of it the sums over pairs do not resolve the growth: the level of a
/// pond that has risen from 5 to 9 rows is 0.2 spacings too high (0.1).
/// Unit: spacings. Test: Bed.WhatTheGroundGivesComesIntoTheParticles.
inline constexpr double reach = 2.0;
/// Volume below which a particle is merged with its nearest neighbour.
/// Unit: volumes of a particle at the start. Test: Bed.ParticlesThatShrinkMerge (untried).
inline constexpr double least_volume = 0.5;
/// Volume above which a particle is divided into two.
/// Unit: volumes of a particle at the start. Test: Bed.WhatTheGroundGivesComesIntoTheParticles (untried).
inline constexpr double most_volume = 1.6;
/// Volume below which a particle without a neighbour becomes part of the film on the bed.
/// Unit: volumes of a particle at the start. Test: none known.
inline constexpr double last_volume = 0.1;
/// Distance up to which a neighbour is near enough to merge with.
/// Unit: spacings. Test: none known.
inline constexpr double merged_within = 1.5;
/// Largest change of a particle's volume in a window.
/// Unit: its volume. Test: none known.
inline constexpr double most_change = 0.2;

}  // namespace poretwin::fluid::bed
