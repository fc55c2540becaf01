// Chosen numbers of the fluid's gauges. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test's name: the test has not yet been seen to fail when the number is halved or doubled.
#pragma once

#include <cstddef>

namespace poretwin::fluid::readings {

/// A gap in the water along a line counts as loose packing up to this width. The water ends at a wider gap.
/// Unit: spacings. Test: none known.
inline constexpr double gap = 2.0;
/// A place under water is searched for up to this distance behind the end of the water.
/// Unit: spacings. Test: none known.
inline constexpr double under_water_within = 12.0;
/// Where the slope of the pressure along a line is less than this, the place where the water ends is not found from it.
/// Unit: rho g. Test: Gauges.OfLevelFlow (untried).
inline constexpr double least_slope = 0.1;
/// The tip of a front is extrapolated from two places. This many particles lie ahead of the place nearer to the tip.
/// Unit: particles. Test: FreeWater.AWedgeReachesAsFarAsItsTip (untried).
inline constexpr double near_tip = 2.0;
/// Number of particles ahead of the place farther from the tip. In a wedge four times as many particles lie ahead of a
/// place twice as far from the tip.
/// Unit: particles. Test: FreeWater.AWedgeReachesAsFarAsItsTip (untried).
inline constexpr double far_from_tip = 8.0;
/// The two places are searched for among this number of foremost particles.
/// Unit: particles. Test: none known.
inline constexpr std::size_t foremost = 64;
/// Depth of the upper of two places through which the surface is extended as a straight line to a face.
/// Unit: spacings. Test: none known.
inline constexpr double exit_shallow = 0.2;
/// Depth of the lower of these two places.
/// Unit: spacings. Test: none known.
inline constexpr double exit_deep = 0.6;

}  // namespace poretwin::fluid::readings
