// Chosen numbers of the stream that erodes soil. What an entry needs: CONTRIBUTING.md.
#pragma once

namespace poretwin::fluid::erosion {

/// Width of the kernel over which the velocity of the stream beside soil is a mean. The water that erosion sets free is
/// slow until the stream has taken it along, and makes up the first row or two: with 1 the shear stress on a bed that
/// erodes is two thirds of that of the stream.
/// Unit: smoothing lengths. Test: none known.
inline constexpr double stream_width = 2.0;

}  // namespace poretwin::fluid::erosion
