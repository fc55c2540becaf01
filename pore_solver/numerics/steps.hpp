// Chosen numbers of the pore water's steps in time. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::pore::steps {

/// Error of the water content in one step, as the mean over the pores, for which the length of steps is chosen: half
/// the step times the change of the rates within it, which is the error of implicit Euler (Kavetski, Binning & Sloan
/// 2001).
/// Unit: pore volumes. Test: srivastava_yeh (untried).
inline constexpr double wanted_error = 2e-3;
/// Error above which a step is repeated with a shorter length.
/// Unit: wanted errors. Test: none known.
inline constexpr double largest_error = 2.5;
/// Safety factor on the step that the error would allow, so that few steps are repeated.
/// Unit: steps. Test: none known.
inline constexpr double caution = 0.9;
/// Least ratio of a step to the last one.
/// Unit: steps. Test: none known.
inline constexpr double shrink = 0.4;
/// Ratio of the next attempt to a step for which Newton's iteration found no solution.
/// Unit: steps. Test: none known.
inline constexpr double shrink_unsolved = 0.25;
/// Largest ratio of a step to the last one.
/// Unit: steps. Test: none known.
inline constexpr double grow = 1.7;
/// Volume of water that moves in the first step.
/// Unit: pore volumes. Test: none known.
inline constexpr double first_share = 1e-3;
/// Sum of the residuals at which Newton's iteration ends. The remaining residual is carried into the next step and not
/// lost.
/// Unit: water that moves in the stage. Test: ponding (untried).
inline constexpr double residual = 1e-2;
/// Upper bound of the sum of the residuals at which Newton's iteration ends, used where much water moves.
/// Unit: pore volumes. Test: none known.
inline constexpr double most_residual = 1e-5;
/// Lower bound of the sum of the residuals at which Newton's iteration ends, used where little water moves.
/// Unit: pore volumes. Test: none known.
inline constexpr double least_residual = 1e-8;
/// Further bound of that sum in soil that moves: the mean head over the soil by which the residual would change the
/// head that the skeleton bears.
/// Unit: largest head borne. Test: none known.
inline constexpr double borne_residual = 1e-4;
/// Volume of air in the pores from which on soil does not count as full. With that much air its water can adapt to its
/// pores by itself.
/// Unit: share of the pores. Test: none known.
inline constexpr double air_in_full_soil = 0.05;
/// Number of Newton iterations after which a step is given up.
/// Unit: iterations. Test: none known.
inline constexpr int most_iterations = 15;
/// Newton iterations before steps that increase the residual are halved. Earlier such steps are needed: a front that
/// enters cells raises the residual at first.
/// Unit: iterations. Test: dam_valley (untried).
inline constexpr int whole_steps = 6;
/// Part of a Newton step at which halving ends.
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
/// Least fraction of the variable u that an iteration leaves, so that u stays positive.
/// Unit: 1. Test: none known.
inline constexpr double least_share = 0.1;

/// Displacement of a point with the soil at which all points are linked anew.
/// Unit: spacings. Test: none known.
inline constexpr double carried_far = 0.05;

}  // namespace poretwin::pore::steps
