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
/// Slope of the pressure along a line below which it is flat, and does not tell where it ends.
/// Unit: rho g. Test: Gauges.OfLevelFlow (untried).
inline constexpr double least_slope = 0.1;
/// Particles ahead of the nearer place by which a front's tip is found.
/// Unit: particles. Test: FreeWater.AWedgeReachesAsFarAsItsTip (untried).
inline constexpr double near_tip = 2.0;
/// The same of the farther one: in a wedge four times as many lie ahead of a place twice as far from the tip.
/// Unit: particles. Test: FreeWater.AWedgeReachesAsFarAsItsTip (untried).
inline constexpr double far_from_tip = 8.0;
/// Foremost particles that are looked at for that.
/// Unit: particles. Test: none known.
inline constexpr std::size_t foremost = 64;
/// Depth of the upper of the two places that are joined up to where a surface meets a face.
/// Unit: spacings. Test: none known.
inline constexpr double exit_shallow = 0.2;
/// The same of the lower one.
/// Unit: spacings. Test: none known.
inline constexpr double exit_deep = 0.6;

}  // namespace poretwin::fluid::readings
