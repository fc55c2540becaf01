// Chosen numbers of faces, their columns, and inlets. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::fluid::faces {

/// Buffer particles per column: enough to fill every kernel that reaches across the face.
/// Unit: particles. Test: Faces.AFaceThatEndsOnAWallPassesTheFlowOfItsHeads (untried).
inline constexpr int buffers_per_column = 4;
/// Distance outside a face from which on a particle is deleted; its column moves back by one spacing.
/// Unit: spacings. Test: none known.
inline constexpr double deletion_depth = 0.25;
/// Rows of still water behind a face with a head into which soil can slide, and columns of it beyond the face's ends.
/// Unit: rows. Test: Faces.FollowSoilThatCanFlow (untried).
inline constexpr int reservoir_rows = 16;
/// Coverage by the soil below which the soil's pore water counts as outside of it. On the steps of a lattice along a
/// slope the coverage is 0.28.
/// Unit: 1. Test: none known.
inline constexpr double left_by_soil = 0.2;

/// Depth inside a face up to which its outermost particle is looked for. The first row stands at a half.
/// Unit: spacings. Test: Seepage.RowsThatAreAheadOfTheirColumnsGoInTurn (untried).
inline constexpr double outermost_within = 0.75;
/// Depth at which a column samples speed and slope: behind the first row, before the second.
/// Unit: spacings. Test: Faces.SlopesAreExactForLinearPressures (untried).
inline constexpr double probe_depth = 0.75;
/// Sum of V W at that depth below which no water counts as standing behind a column.
/// Unit: 1. Test: none known.
inline constexpr double least_seen = 0.05;
/// Smoothing length of the fit of a column's pressure slope: half of that of the operators.
/// Unit: spacings. Test: Faces.SlopesAreExactForLinearPressures (untried).
inline constexpr double fit_length = 0.65;
/// Mean square of the particles' depth below which a column's fit uses this value instead: particles so near the face
/// say nothing of the slope.
/// Unit: spacings^2. Test: none known.
inline constexpr double least_fitted = 0.04;

/// Depth inside a face at which its soil is looked up.
/// Unit: spacings. Test: none known.
inline constexpr double soil_depth = 0.25;
/// Least depth of a front entering dry ground that is used for its speed at the window's end.
/// Unit: spacings. Test: Seepage.AFrontIsRightFromItsFirstSpacingOn (untried).
inline constexpr double least_front_depth = 0.25;
/// Least distance between the surface and a particle at a dry face.
/// Unit: spacings. Test: none known.
inline constexpr double least_exit_distance = 0.1;

/// Averaging time of the current in front of a sill. The unit is the time in which a wave passes the water that is
/// averaged over.
/// Unit: wave's ways. Test: Passage.OverABroadCrestTheDischargeIsCritical (untried).
inline constexpr double current_waves = 10.0;

}  // namespace poretwin::fluid::faces
