// Chosen numbers of faces, their columns, and inlets. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test's name: the test has not yet been seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::fluid::faces {

/// Buffer particles per column: enough to fill every kernel that reaches across the face.
/// Unit: particles. Test: Faces.AFaceThatEndsOnAWallPassesTheFlowOfItsHeads (untried).
inline constexpr int buffers_per_column = 4;
/// A particle is deleted beyond this distance outside a face; its column of buffers then moves back by one spacing.
/// Unit: spacings. Test: none known.
inline constexpr double deletion_depth = 0.25;
/// Rows of still water behind a face with a head where soil can slide into it, and columns of it beyond each end.
/// Unit: rows. Test: Faces.FollowSoilThatCanFlow (untried).
inline constexpr int reservoir_rows = 16;
/// Pore water counts as outside of its soil where the coverage by the soil is below this value. On the steps of a
/// lattice along a slope the coverage is 0.28.
/// Unit: 1. Test: none known.
inline constexpr double left_by_soil = 0.2;

/// The outermost particle inside a face is searched for up to this depth. The first row stands at half a spacing.
/// Unit: spacings. Test: Seepage.RowsThatAreAheadOfTheirColumnsGoInTurn (untried).
inline constexpr double outermost_within = 0.75;
/// Depth at which a column samples speed and pressure slope: between the first row of particles and the second.
/// Unit: spacings. Test: Faces.SlopesAreExactForLinearPressures (untried).
inline constexpr double probe_depth = 0.75;
/// No water counts as standing behind a column where the sum of V W at the probe depth is below this value.
/// Unit: 1. Test: none known.
inline constexpr double least_seen = 0.05;
/// Smoothing length of the fit of a column's pressure slope. It is half of the smoothing length of the operators.
/// Unit: spacings. Test: Faces.SlopesAreExactForLinearPressures (untried).
inline constexpr double fit_length = 0.65;
/// Least mean square of the particles' depths in the fit of a column's slope: a smaller mean square is replaced by it.
/// Particles so near the face do not determine a slope.
/// Unit: spacings^2. Test: none known.
inline constexpr double least_fitted = 0.04;

/// Depth inside a face at which the properties of its soil are looked up.
/// Unit: spacings. Test: none known.
inline constexpr double soil_depth = 0.25;
/// The depth of a front that enters dry ground is at least this value where its speed at the window's end is computed.
/// Unit: spacings. Test: Seepage.AFrontIsRightFromItsFirstSpacingOn (untried).
inline constexpr double least_front_depth = 0.25;
/// Least distance between the surface and a particle at a dry face.
/// Unit: spacings. Test: none known.
inline constexpr double least_exit_distance = 0.1;

/// Averaging time of the current in front of a sill. Its unit is the time in which a wave crosses the water over which
/// the current is averaged.
/// Unit: crossing times of a wave. Test: Passage.OverABroadCrestTheDischargeIsCritical (untried).
inline constexpr double current_waves = 10.0;

}  // namespace poretwin::fluid::faces
