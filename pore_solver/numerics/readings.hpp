// Chosen numbers of the field's gauges. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::pore::readings {

/// Depth below a face at which the water table is searched for, and again at twice that depth, to find where it meets
/// the face. Closer to the face the cells at the border distort the reading; farther from it the depth of the water
/// table is no power of the distance.
/// Unit: spacings. Test: embankment_seepage_rigid (untried).
inline constexpr double exit_depth = 1.5;

}  // namespace poretwin::pore::readings
