// Chosen numbers of basins beside the pore water's field. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test's name: the test has not yet been seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::pore::basins {

/// Depth below a level part of a face within which the basin's water wets the part in part. It makes the inflow a
/// continuous function of the level. It is far below the errors of the heads.
/// Unit: spacings. Test: none known.
inline constexpr double film = 1e-2;
/// The error of a basin's level in one step is measured against the depth of its water, or against this length where
/// that is less. It is allowed to be as large as the error of the water content (steps::wanted_error).
/// Unit: spacings. Test: FieldBasin.AFallingHeadIsExponential (untried).
inline constexpr double least_depth = 1.0;

}  // namespace poretwin::pore::basins
