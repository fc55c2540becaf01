// Chosen numbers of soil that counts as at rest. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test's name: the test has not yet been seen to fail when the number is halved or doubled.
// Unit "travel times of a wave": the time in which an elastic wave crosses the soil's height.
#pragma once

namespace poretwin::solid::sleep {

/// Departure from rest (docs/theory/equilibrium.md) above which a particle counts as moving.
/// Unit: the reference acceleration. Test: none known.
inline constexpr double restless = 3e-3;
/// Fraction of the mass that may move while the soil as a whole counts as at rest. Such mass is grains that ravel or
/// creep at a surface.
/// Unit: 1. Test: none known.
inline constexpr double local_share = 0.05;
/// A change of the degree of saturation by more than this ends the rest of soil whose cohesion depends on saturation.
/// Unit: 1. Test: none known.
inline constexpr double softening = 0.01;
/// Waves are damped while the departure of the soil from rest (docs/theory/equilibrium.md; rms) is below this value.
/// Unit: `wake_above` of the case. Test: none known.
inline constexpr double damped_below = 10.0;

/// Distance that elastic waves travel between two checks for activity.
/// Unit: spacings. Test: none known.
inline constexpr double travel = 5.0;
/// Time after which soil that has not moved counts as calm: two periods of a column of the soil's height.
/// Unit: travel times of a wave. Test: Regions.OfACollapseSleepAndErrLittle.
inline constexpr double calm_after = 8.0;
/// Time after which soil that has not moved falls asleep.
/// Unit: travel times of a wave. Test: Regions.OfACollapseSleepAndErrLittle.
inline constexpr double asleep_after = 12.0;
/// Time between two checks for soil that may fall asleep.
/// Unit: travel times of a wave. Test: none known.
inline constexpr double between_checks = 1.0;
/// Width of the margin of soil that stays awake around soil that is not calm.
/// Unit: ranges of the pair lists. Test: none known.
inline constexpr double margin = 2.0;

}  // namespace poretwin::solid::sleep
