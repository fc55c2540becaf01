// Chosen numbers of the pore water's steps in time. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test's name: the test has not yet been seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::pore::steps {

/// The length of steps is chosen such that the error of the water content in one step, as the mean over the pores, has
/// this value. The error is that of implicit Euler: half the step times the change of the rates within it (Kavetski,
/// Binning & Sloan 2001).
/// Unit: pore volumes. Test: srivastava_yeh (untried).
inline constexpr double wanted_error = 2e-3;
/// A step whose error exceeds this value is repeated with a shorter length.
/// Unit: wanted errors. Test: none known.
inline constexpr double largest_error = 2.5;
/// Safety factor on the length of the step that the error would allow. It keeps the number of repeated steps small.
/// Unit: steps. Test: none known.
inline constexpr double caution = 0.9;
/// Share of air in a cell below which the fall of water into it from above dies out, linearly. A cell through which
/// water falls steadily holds about as much air, and so much less water passes.
/// Unit: 1, volume of air over that of the cell's pores. Test: PoreColumn.WaterSeepsIntoDrySoilByItsWeight (untried).
inline constexpr double last_air = 0.01;
/// Least ratio of a step's length to that of the last step.
/// Unit: steps. Test: none known.
inline constexpr double shrink = 0.4;
/// Ratio of the next attempt's length to that of a step for which Newton's iteration found no solution.
/// Unit: steps. Test: none known.
inline constexpr double shrink_unsolved = 0.25;
/// Largest ratio of a step's length to that of the last step.
/// Unit: steps. Test: none known.
inline constexpr double grow = 1.7;
/// Volume of water that moves in the first step.
/// Unit: pore volumes. Test: none known.
inline constexpr double first_share = 1e-3;
/// Newton's iteration ends where the sum of the residuals falls to this value. The remaining residual is carried into
/// the next step and not lost.
/// Unit: water that moves in the stage. Test: ponding (untried).
inline constexpr double residual = 1e-2;
/// Upper bound of the sum of the residuals at which Newton's iteration ends. It applies where much water moves.
/// Unit: pore volumes. Test: none known.
inline constexpr double most_residual = 1e-5;
/// Lower bound of the sum of the residuals at which Newton's iteration ends. It applies where little water moves.
/// Unit: pore volumes. Test: none known.
inline constexpr double least_residual = 1e-8;
/// Further bound of the sum of the residuals, in soil that moves: mean over the soil of the change of the head on the
/// skeleton that the residual would cause.
/// Unit: largest head on the skeleton. Test: none known.
inline constexpr double borne_residual = 1e-4;
/// Soil counts as full where its pores contain less air than this. With more air its water can adapt to a change of the
/// pores by itself.
/// Unit: fraction of the pore volume. Test: none known.
inline constexpr double air_in_full_soil = 0.05;
/// Number of Newton iterations after which a step is given up.
/// Unit: iterations. Test: none known.
inline constexpr int most_iterations = 15;
/// After this number of Newton iterations, steps that increase the residual are halved. Before, they are needed: a
/// front that enters cells raises the residual at first.
/// Unit: iterations. Test: dam_valley (untried).
inline constexpr int whole_steps = 6;
/// Fraction of a Newton step below which it is not halved further.
/// Unit: 1. Test: none known.
inline constexpr double least_part = 0.1;
/// Residual at which a linear solve ends, over its initial value.
/// Unit: 1. Test: none known.
inline constexpr double linear_residual = 1e-2;
/// Residual at which the solve for the error of the heads ends, over its initial value.
/// Unit: 1. Test: none known.
inline constexpr double error_residual = 0.1;
/// Largest number of iterations in a linear solve; Newton's iteration continues with the result.
/// Unit: iterations. Test: none known.
inline constexpr int most_linear_iterations = 100;
/// An iteration leaves at least this fraction of the variable u, so that u stays positive.
/// Unit: 1. Test: none known.
inline constexpr double least_share = 0.1;

/// All points are linked anew once a point has moved by this length with the soil.
/// Unit: spacings. Test: none known.
inline constexpr double carried_far = 0.05;

}  // namespace poretwin::pore::steps
