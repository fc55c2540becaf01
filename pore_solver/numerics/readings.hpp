// Chosen numbers of the field's gauges. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test's name: the test has not yet been seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::pore::readings {

/// The water table is searched for at this depth below a face and at twice this depth, to find where it intersects the
/// face. Closer to the face the cells at the border distort the reading. Farther from it the depth of the water table
/// is no power of the distance.
/// Unit: spacings. Test: embankment_seepage_rigid (untried).
inline constexpr double exit_depth = 1.5;

}  // namespace poretwin::pore::readings
