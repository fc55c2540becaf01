// Chosen numbers of the solid's gauges. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::solid::readings {

/// Determinant of a fit's scaled moments below which there are too few neighbours for a slope.
/// Unit: 1. Test: none known.
inline constexpr double least_determinant = 1e-6;
/// Coverage from which on a particle lies inside a deposit.
/// Unit: 1. Test: none known.
inline constexpr double inside_cover = 0.8;
/// How far its neighbours' centre may lie off such a particle.
/// Unit: h. Test: none known.
inline constexpr double inside_centre = 0.1;
/// Step in which fronts and surfaces are looked for.
/// Unit: spacings. Test: none known.
inline constexpr double step = 0.25;
/// Distance up to which two particles are links of a slip surface.
/// Unit: spacings. Test: SlipSurface.IsAsStrongAsItsWeakestLink (untried).
inline constexpr double link = 1.5;

}  // namespace poretwin::solid::readings
