// Chosen numbers of the constitutive models and of tests of a single point. What an entry needs: CONTRIBUTING.md.
#pragma once

namespace poretwin::solid::material {

/// The logarithmic mean of two numbers is evaluated by its formula where their relative difference exceeds this value.
/// Otherwise the arithmetic mean is used, which is as exact there.
/// Unit: 1. Test: none known.
inline constexpr double logarithmic_from = 1e-4;
/// The deviator counts as not turned where a trial stress turns it by no more than this angle.
/// Unit: rad. Test: none known.
inline constexpr double little_angle = 0.005;

}  // namespace poretwin::solid::material

namespace poretwin::solid::cam_clay {

/// Largest elastic change of the pressure in one implicit step of Cam-Clay, and largest change of the deviator over the
/// pressure. Longer increments are divided: the error of a step falls with the square of the pressure's change and
/// linearly with the deviator's.
/// Unit: the pressure. Test: none known.
inline constexpr double longest_step = 0.05;
/// Largest number of steps into which an increment is divided. Soil that has not failed needs fewer steps.
/// Unit: steps. Test: none known (a guard).
inline constexpr double most_steps = 1e5;
/// Newton's iteration ends at this residual: of the yield function over pc^2 (pc: preconsolidation pressure), and of
/// the plastic compression.
/// Unit: 1. Test: none known.
inline constexpr double reached = 1e-11;
/// A step is divided after this number of rounds of Newton's iteration. It usually needs 4 or 5 rounds.
/// Unit: rounds. Test: none known (time, not results).
inline constexpr int rounds = 15;
/// Largest factor by which the steps are refined before the search is given up.
/// Unit: 1. Test: none known (a guard).
inline constexpr double finest = 256.0;

}  // namespace poretwin::solid::cam_clay

namespace poretwin::solid::mu_i {

/// Error at which the searches for the plastic shear strain and the pressure of an increment end: of the shear stress
/// over the trial one, and of the square root of the pressure over itself.
/// Unit: 1. Test: MuI.ShearsSteadilyAtTheFrictionOfItsRate (untried).
inline constexpr double reached = 1e-10;
/// Largest number of rounds of these searches; 3 to 8 are usual.
/// Unit: rounds. Test: none known (a guard).
inline constexpr int rounds = 100;

}  // namespace poretwin::solid::mu_i

namespace poretwin::solid::element {

/// Accepted residual of the conditions of an element test on stress and strain at the end of a step, over the residual
/// at its beginning. Residuals of stress are divided by the constrained modulus.
/// Unit: 1. Test: none known.
inline constexpr double reached = 1e-10;
/// Change of the strain with which the tangent is found by differences, over the strain that is sought.
/// Unit: 1. Test: none known (time, not results).
inline constexpr double probe = 1e-4;
/// A direction of strain counts as without effect on the conditions where its pivot, over the largest, is below this.
/// Unit: 1. Test: none known.
inline constexpr double singular = 1e-6;
/// Largest number of rounds of Newton's iteration in one step.
/// Unit: rounds. Test: none known.
inline constexpr int rounds = 60;
/// Least fraction of a correction of Newton's iteration that is tried.
/// Unit: 1. Test: none known.
inline constexpr double least_share = 0.01;

}  // namespace poretwin::solid::element
