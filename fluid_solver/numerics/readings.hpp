// Chosen numbers of the fluid's gauges. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

#include <cstddef>

namespace poretwin::fluid::readings {

/// Gap in the water on a line that is loose packing, and not its end.
/// Unit: spacings. Test: none known.
inline constexpr double gap = 2.0;
/// How far behind the end of the water a place under water is looked for.
/// Unit: spacings. Test: none known.
inline constexpr double under_water_within = 12.0;
/// Slope of the pressure along a line below which it is flat and does not show where the water ends.
/// Unit: rho g. Test: Gauges.OfLevelFlow (untried).
inline constexpr double least_slope = 0.1;
/// A front's tip is found from two places; number of particles ahead of the nearer one.
/// Unit: particles. Test: FreeWater.AWedgeReachesAsFarAsItsTip (untried).
inline constexpr double near_tip = 2.0;
/// Number of particles ahead of the farther place: in a wedge four times as many lie ahead of a place twice as far from
/// the tip.
/// Unit: particles. Test: FreeWater.AWedgeReachesAsFarAsItsTip (untried).
inline constexpr double far_from_tip = 8.0;
/// Number of foremost particles among which these two places are looked for.
/// Unit: particles. Test: none known.
inline constexpr std::size_t foremost = 64;
/// The surface is extended as a straight line through two places to where it meets a face; depth of the upper place.
/// Unit: spacings. Test: none known.
inline constexpr double exit_shallow = 0.2;
/// Depth of the lower of these two places.
/// Unit: spacings. Test: none known.
inline constexpr double exit_deep = 0.6;

}  // namespace poretwin::fluid::readings
