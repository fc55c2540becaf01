// Chosen numbers of the field's gauges. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::pore::readings {

/// Depth under a face at which the water table is looked for, and once more at twice that, to read where it meets the
/// face. Nearer to it the cells at the border distort the reading, farther from it the table is no longer a power of
/// the distance.
/// Unit: spacings. Test: embankment_seepage_rigid (untried).
inline constexpr double exit_depth = 1.5;

}  // namespace poretwin::pore::readings
