// Chosen numbers of soil that counts as at rest. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::solid::sleep {

/// Departure from rest above which a particle counts as moving.
/// Unit: the reference acceleration. Test: none known.
inline constexpr double restless = 3e-3;
/// Fraction of the mass that may move while the soil as a whole counts as at rest: grains that ravel or creep at a
/// surface.
/// Unit: 1. Test: none known.
inline constexpr double local_share = 0.05;
/// Change of the saturation that disturbs a rest, where a cohesion follows it.
/// Unit: 1. Test: Regions.WakeForWater (untried).
inline constexpr double softening = 0.01;
/// Departure from rest (rms) below which waves in soil alone are damped.
/// Unit: `wake_above` of the case. Test: Sleep.DampingEndsWithTheFirstYielding (untried).
inline constexpr double damped_below = 10.0;

/// Way of waves between two checks for activity.
/// Unit: spacings. Test: none known.
inline constexpr double travel = 5.0;
/// Time after which soil that does not move is calm: two periods of a column as high.
/// Unit: ways of a wave. Test: Regions.OfACollapseSleepAndErrLittle (untried).
inline constexpr double calm_after = 8.0;
/// Time after which calm soil sleeps.
/// Unit: ways of a wave. Test: Regions.OfACollapseSleepAndErrLittle (untried).
inline constexpr double asleep_after = 12.0;
/// Time between two checks for sleep.
/// Unit: ways of a wave. Test: none known.
inline constexpr double between_checks = 1.0;
/// Margin of soil awake around what is not calm.
/// Unit: ranges of the pair lists. Test: Regions.FeelAllTheirNeighbours (untried).
inline constexpr double margin = 2.0;

}  // namespace poretwin::solid::sleep
