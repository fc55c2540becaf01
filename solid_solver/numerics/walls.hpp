// Chosen numbers of the soil's walls and loads. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::solid::walls {

/// Effect of a wall's slip on a particle, below which the two do not touch.
/// Unit: 1 / spacing. Test: FrictionalWall.HoldsALayerBelowItsAngle (untried).
inline constexpr double touches_from = 0.05;
/// Least share of the spread of the images behind a frictional wall that must lie along it for the slopes of the stress
/// along the wall to be evaluated: single grains have none.
/// Unit: 1. Test: none known.
inline constexpr double least_spread = 0.1;
/// Rows of particles behind a rough wall: as deep as the kernel reaches, h = 1.2 spacings.
/// Unit: rows. Test: RoughWall.HoldsThreeRowsOfTheSoilAndClosesCorners (untried).
inline constexpr int rough_rows = 3;
/// Least depth of such a particle behind all walls: the first row stands at a half.
/// Unit: spacings. Test: RoughWall.HoldsThreeRowsOfTheSoilAndClosesCorners (untried).
inline constexpr double least_depth = 0.4;
/// Least square of their distance: round corners rows overlap.
/// Unit: spacings^2. Test: RoughWall.HoldsThreeRowsOfTheSoilAndClosesCorners (untried).
inline constexpr double least_apart = 0.5;

/// How far the soil's surface may lie off a load's line: as far as `check` lets it.
/// Unit: spacings. Test: Load.BeyondTheSoilIsNone (untried).
inline constexpr double farthest_load = 2.25;
/// How far beside the line soil that begins on it is looked for: beyond rounding, short of a tip.
/// Unit: spacings. Test: none known.
inline constexpr double beside_line = 1e-3;
/// Step along the line in which its length along soil is measured.
/// Unit: spacings. Test: Load.OnALineThatEndsWithinAColumnHasTheLengthOfTheLine (untried).
inline constexpr double line_step = 5e-3;
/// How far the first row may have moved off a loaded face while the water takes the load's share: in coarse, soft soil
/// what water and soil differ by grew from 0.14 spacings on, in every window.
/// Unit: spacings. Test: Load.IsBalancedByPressureRowByRow (untried).
inline constexpr double moved_off_face = 0.1;

}  // namespace poretwin::solid::walls
