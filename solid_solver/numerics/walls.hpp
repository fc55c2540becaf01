// Chosen numbers of the soil's walls and loads. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::solid::walls {

/// Effect of a wall's slip on a particle's velocity gradient below which the particle does not touch the wall.
/// Unit: 1 / spacing. Test: FrictionalWall.HoldsALayerBelowItsAngle (untried).
inline constexpr double touches_from = 0.05;
/// Least share of the spread of the images behind a frictional wall that must lie along it for the slopes of the stress
/// along the wall to be evaluated: single grains have none.
/// Unit: 1. Test: none known.
inline constexpr double least_spread = 0.1;
/// Rows of fixed particles behind a rough wall: as many as the kernel reaches with h = 1.2 spacings.
/// Unit: rows. Test: RoughWall.HoldsThreeRowsOfTheSoilAndClosesCorners (untried).
inline constexpr int rough_rows = 3;
/// Least depth of a fixed particle behind all rough walls. The first row lies at a half.
/// Unit: spacings. Test: RoughWall.HoldsThreeRowsOfTheSoilAndClosesCorners (untried).
inline constexpr double least_depth = 0.4;
/// Least square of the distance between two fixed particles: rows overlap round corners.
/// Unit: spacings^2. Test: RoughWall.HoldsThreeRowsOfTheSoilAndClosesCorners (untried).
inline constexpr double least_apart = 0.5;

/// Largest distance between the soil's surface and the line of a load: `check` allows as much.
/// Unit: spacings. Test: Load.BeyondTheSoilIsNone (untried).
inline constexpr double farthest_load = 2.25;
/// Distance to the side of a load's line at which soil is looked for: more than rounding, less than the size of a tip.
/// Unit: spacings. Test: none known.
inline constexpr double beside_line = 1e-3;
/// Step along a load's line in which the part that lies on soil is measured.
/// Unit: spacings. Test: Load.OnALineThatEndsWithinAColumnHasTheLengthOfTheLine (untried).
inline constexpr double line_step = 5e-3;
/// Largest displacement of the first row off a loaded face up to which the pressure gradient below it includes the load
/// (share_load). In coarse, soft soil the difference between water and soil grew from window to window beyond 0.14
/// spacings.
/// Unit: spacings. Test: Load.IsBalancedByPressureRowByRow (untried).
inline constexpr double moved_off_face = 0.1;

/// Way that a plate may sink into soil that lies beside its ends. Farther on, soil that heaves beside it may flow over
/// the plate. The bearing capacity of clay stays within 7 % up to here (docs/theory/plates.md).
/// Unit: spacings. Test: Plate.ThatSinksFarBesideSoilEndsTheRun.
inline constexpr double deepest_plate = 1.5;
/// Largest pull of a plate at the soil, over the largest force between both, from which on the run warns of it. Waves
/// make a plate pull for an instant.
/// Unit: 1. Test: Plate.ThatPullsMoreThanAHundredthIsWarnedOf.
inline constexpr double noticed_pull = 0.01;

}  // namespace poretwin::solid::walls
