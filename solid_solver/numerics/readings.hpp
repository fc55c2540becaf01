// Chosen numbers of the solid's gauges. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test's name: the test has not yet been seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::solid::readings {

/// With a determinant of the scaled moment matrix below this, a particle has too few neighbours to fit a slope.
/// Unit: 1. Test: none known.
inline constexpr double least_determinant = 1e-6;
/// A particle belongs to the crest where its coverage by the kernel (sum V W) is at least this value: 0.39 of a grain
/// alone, 0.51 of two that touch, 0.63 in a row of grains.
/// Unit: 1. Test: Erosion.TheCrestIsNotAGrainInFlight (untried).
inline constexpr double in_contact = 0.57;
/// A particle counts as inside a deposit where its coverage by the kernel (sum V W) is at least this value.
/// Unit: 1. Test: none known.
inline constexpr double inside_cover = 0.8;
/// A particle inside a deposit lies no farther than this from the centre of its neighbours.
/// Unit: h. Test: none known.
inline constexpr double inside_centre = 0.1;
/// Step in which fronts and surfaces are searched for.
/// Unit: spacings. Test: none known.
inline constexpr double step = 0.25;
/// Largest distance between two particles that are joined in a slip surface.
/// Unit: spacings. Test: SlipSurface.IsAsStrongAsItsWeakestLink.
inline constexpr double link = 1.5;

/// Largest local factor of safety written to frames. Without shear stress the factor is infinite, which many programs
/// that read frames cannot show.
/// Unit: 1. Test: LocalFactor.IsMissingInElasticSoilAndLimitedWithoutShear.
inline constexpr double largest_local_factor = 100.0;

}  // namespace poretwin::solid::readings
