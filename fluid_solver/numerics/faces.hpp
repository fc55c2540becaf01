// Chosen numbers of faces, their columns, and inlets. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::fluid::faces {

/// Buffer particles per column: enough to fill every kernel that reaches the face.
/// Unit: particles. Test: Faces.AFaceThatEndsOnAWallPassesTheFlowOfItsHeads (untried).
inline constexpr int buffers_per_column = 4;
/// A particle that has left through a face by more than this is deleted; the column steps back by one.
/// Unit: spacings. Test: none known.
inline constexpr double deletion_depth = 0.25;
/// Rows of still water that soil can slide into behind a face with a head, and columns of them beyond its ends.
/// Unit: rows. Test: Faces.FollowSoilThatCanFlow (untried).
inline constexpr int reservoir_rows = 16;
/// Coverage by the soil below which its water is out of it: on the steps of a lattice along a slope it is 0.28.
/// Unit: 1. Test: none known.
inline constexpr double left_by_soil = 0.2;

/// Depth in which a face's outermost particle is looked for: the first row stands at a half.
/// Unit: spacings. Test: Seepage.RowsThatAreAheadOfTheirColumnsGoInTurn (untried).
inline constexpr double outermost_within = 0.75;
/// Depth of the place from which a column takes speed and slope: behind the first row, before the second.
/// Unit: spacings. Test: Faces.SlopesAreExactForLinearPressures (untried).
inline constexpr double probe_depth = 0.75;
/// Sum of V W there below which no water stands behind a column.
/// Unit: 1. Test: none known.
inline constexpr double least_seen = 0.05;
/// Smoothing length of the fit of a column's slope: half of the operators'.
/// Unit: spacings. Test: Faces.SlopesAreExactForLinearPressures (untried).
inline constexpr double fit_length = 0.65;
/// Mean square of depth below which a column's fit is held up to it: its rows lie too near the face.
/// Unit: spacings^2. Test: none known.
inline constexpr double least_fitted = 0.04;

/// Depth inside at which the soil of a face is looked up.
/// Unit: spacings. Test: none known.
inline constexpr double soil_depth = 0.25;
/// Least depth of a front that enters dry ground, of which its speed at the window's end is made.
/// Unit: spacings. Test: Seepage.AFrontIsRightFromItsFirstSpacingOn (untried).
inline constexpr double least_front_depth = 0.25;
/// Least distance of the surface from a particle at a dry face.
/// Unit: spacings. Test: none known.
inline constexpr double least_exit_distance = 0.1;

/// Averaging time of the current in front of a sill, in the times that a wave takes past the water averaged over.
/// Unit: wave's ways. Test: Passage.OverABroadCrestTheDischargeIsCritical (untried).
inline constexpr double current_waves = 10.0;

}  // namespace poretwin::fluid::faces
