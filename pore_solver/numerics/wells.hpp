// Chosen numbers of wells in the pore water's field. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test's name: the test has not yet been seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::pore::wells {

/// Radius of the patch of points around a well's axis from which the well's equivalent radius is found. On a square
/// lattice, the equivalent radius is 0.1985 spacings to 0.5 % with this patch. A larger patch could reach beyond the
/// soil that `check` demands around a well.
/// Unit: spacings. Test: Wells.OnALatticeTheEquivalentRadiusIsThatOfPeaceman.
inline constexpr double patch_radius = 3.2;
/// Length by which the patch continues along the axis beyond the screen's ends.
/// Unit: spacings. Test: none known.
inline constexpr double patch_beyond = 2.0;
/// Accuracy to which a well's level is found for its discharge. It is far below the errors of the heads, so that the
/// pumped volume is exact to rounding.
/// Unit: spacings. Test: none known.
inline constexpr double level_accuracy = 1e-12;
/// Largest number of trials in the search for this level. Bisection alone would need about 50.
/// Unit: trials. Test: none known.
inline constexpr int most_searches = 200;
/// Difference of levels over which the derivative of a screen's flow is taken. It only affects how fast Newton's
/// iteration converges.
/// Unit: spacings. Test: none known.
inline constexpr double level_step = 1e-4;

}  // namespace poretwin::pore::wells
