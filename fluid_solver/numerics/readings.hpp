// Chosen numbers of the fluid's gauges. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

#include <cstddef>

namespace poretwin::fluid::readings {

/// Largest gap in the water on a line that counts as loose packing. A wider gap is the end of the water.
/// Unit: spacings. Test: none known.
inline constexpr double gap = 2.0;
/// Distance behind the end of the water up to which a place under water is looked for.
/// Unit: spacings. Test: none known.
inline constexpr double under_water_within = 12.0;
/// Slope of the pressure along a line below which the pressure does not show where the water ends.
/// Unit: rho g. Test: Gauges.OfLevelFlow (untried).
inline constexpr double least_slope = 0.1;
/// The tip of a front is extrapolated from two places. Number of particles ahead of the one nearer to the tip.
/// Unit: particles. Test: FreeWater.AWedgeReachesAsFarAsItsTip (untried).
inline constexpr double near_tip = 2.0;
/// Number of particles ahead of the farther of these places. In a wedge four times as many lie ahead of a place twice
/// as far from the tip.
/// Unit: particles. Test: FreeWater.AWedgeReachesAsFarAsItsTip (untried).
inline constexpr double far_from_tip = 8.0;
/// Number of foremost particles among which these two places are looked for.
/// Unit: particles. Test: none known.
inline constexpr std::size_t foremost = 64;
/// Depth of the upper of two places through which the surface is extended as a straight line to a face.
/// Unit: spacings. Test: none known.
inline constexpr double exit_shallow = 0.2;
/// Depth of the lower of these two places.
/// Unit: spacings. Test: none known.
inline constexpr double exit_deep = 0.6;

}  // namespace poretwin::fluid::readings
