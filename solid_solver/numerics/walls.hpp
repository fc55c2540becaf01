// Chosen numbers of the soil's walls and loads. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test's name: the test has not yet been seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::solid::walls {

/// A particle touches a wall if a unit of wall slip lowers its velocity gradient across the wall by this value or more.
/// Unit: 1 / spacing. Test: none known.
inline constexpr double touches_from = 0.05;
/// The slopes of the stress along a frictional wall are evaluated where at least this fraction of the spread of the
/// images behind it lies along the wall. Single grains have no such slope.
/// Unit: 1. Test: none known.
inline constexpr double least_spread = 0.1;
/// Number of rows of fixed particles behind a rough wall. The kernel with h = 1.2 spacings reaches three rows.
/// Unit: rows. Test: RoughWall.HoldsThreeRowsOfTheSoilAndClosesCorners.
inline constexpr int rough_rows = 3;
/// Least depth of a fixed particle behind all rough walls. The first row lies at half a spacing.
/// Unit: spacings. Test: RoughWall.HoldsThreeRowsOfTheSoilAndClosesCorners.
inline constexpr double least_depth = 0.4;
/// Least square of the distance between two fixed particles. Particles of overlapping rows at corners would be closer.
/// Unit: spacings^2. Test: RoughWall.HoldsThreeRowsOfTheSoilAndClosesCorners.
inline constexpr double least_apart = 0.5;

/// Largest distance between the soil's surface and the line of a load. `check` allows the same distance.
/// Unit: spacings. Test: Load.BeyondTheSoilIsNone.
inline constexpr double farthest_load = 2.25;
/// Distance to the side of a load's line at which soil is searched for: above rounding, below the size of a tip.
/// Unit: spacings. Test: none known.
inline constexpr double beside_line = 1e-3;
/// Step along a load's line with which the part that lies on soil is measured.
/// Unit: spacings. Test: none known.
inline constexpr double line_step = 5e-3;
/// The pressure gradient below a loaded face includes the load (share_load) while the first row has moved off the face
/// by no more than this. Beyond 0.14 spacings the difference between the motion of water and soil grew from window to
/// window in coarse, soft soil.
/// Unit: spacings. Test: none known.
inline constexpr double moved_off_face = 0.1;

/// Largest distance by which a plate may sink into soil beside its ends. Beyond it, soil that heaves beside the plate
/// may flow over it. The bearing capacity of clay stays within 7 % up to this distance (docs/theory/plates.md).
/// Unit: spacings. Test: Plate.ThatSinksFarBesideSoilEndsTheRun.
inline constexpr double deepest_plate = 1.5;
/// The run warns of a plate that pulls at the soil where the largest pull, over the largest force between both, is at
/// least this value. A wave can make a plate pull for an instant.
/// Unit: 1. Test: Plate.ThatPullsMoreThanAHundredthIsWarnedOf.
inline constexpr double noticed_pull = 0.01;
/// A part of a plate that lifts comes off where it pulls at the soil by more than this. With less, rounding and waves
/// would let parts come off and touch again in turn.
/// Unit: sum of the forces of all parts. Test: none known.
inline constexpr double comes_off_above = 0.01;

}  // namespace poretwin::solid::walls
