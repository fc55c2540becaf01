// Chosen numbers of the pore water's steps in time. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::pore::steps {

/// Error that one step may make in the water content, as the mean over the pores: half the step times the change of the
/// rates within it, which is implicit Euler's (Kavetski, Binning & Sloan 2001). Steps are chosen for it.
/// Unit: pore volumes. Test: srivastava_yeh (untried).
inline constexpr double wanted_error = 2e-3;
/// Error with which a step is repeated, shorter.
/// Unit: wanted errors. Test: none known.
inline constexpr double largest_error = 2.5;
/// By how much a step is chosen shorter than what its error would allow, so that few are repeated.
/// Unit: steps. Test: none known.
inline constexpr double caution = 0.9;
/// How much shorter a step may be than the last one.
/// Unit: steps. Test: none known.
inline constexpr double shrink = 0.4;
/// Length of the next attempt after a step for which Newton's iteration found no solution.
/// Unit: steps. Test: none known.
inline constexpr double shrink_unsolved = 0.25;
/// How much longer a step may be than the last one.
/// Unit: steps. Test: none known.
inline constexpr double grow = 1.7;
/// Water that moves in the first step.
/// Unit: pore volumes. Test: none known.
inline constexpr double first_share = 1e-3;
/// Sum of the residuals at which Newton's iteration ends. What is left is carried into the next step, not lost.
/// Unit: water that moves in the stage. Test: ponding (untried).
inline constexpr double residual = 1e-2;
/// Largest sum of the residuals at which Newton's iteration ends, however much water moves.
/// Unit: pore volumes. Test: none known.
inline constexpr double most_residual = 1e-5;
/// Sum of the residuals that need not be undercut, however little water moves.
/// Unit: pore volumes. Test: none known.
inline constexpr double least_residual = 1e-8;
/// The same in soil that moves: the head that it would change what the skeleton bears by, mean over the soil.
/// Unit: largest head borne. Test: none known.
inline constexpr double borne_residual = 1e-4;
/// Air in the pores from which on soil is not full, so that its water can fit its pores by itself.
/// Unit: share of the pores. Test: none known.
inline constexpr double air_in_full_soil = 0.05;
/// Iterations after which a step is given up.
/// Unit: iterations. Test: none known.
inline constexpr int most_iterations = 15;
/// Residual of each linear solve, over what it began with.
/// Unit: 1. Test: none known.
inline constexpr double linear_residual = 1e-2;
/// Residual of the solve for the error of the heads, over what it began with.
/// Unit: 1. Test: none known.
inline constexpr double error_residual = 0.1;
/// Iterations of a linear solve at most; Newton's iteration goes on with what it has found.
/// Unit: iterations. Test: none known.
inline constexpr int most_linear_iterations = 100;
/// What an iteration leaves of the variable u at least, so that it stays positive.
/// Unit: 1. Test: none known.
inline constexpr double least_share = 0.1;

/// How far the soil carries a point before all are linked anew.
/// Unit: spacings. Test: none known.
inline constexpr double carried_far = 0.05;

}  // namespace poretwin::pore::steps
