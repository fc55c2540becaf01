// Chosen numbers of the return to the cone. What an entry needs: CONTRIBUTING.md.
#pragma once

namespace poretwin::solid::material {

/// Relative difference from which on a logarithmic mean is taken as such; below, an arithmetic one is as exact.
/// Unit: 1. Test: none known.
inline constexpr double logarithmic_from = 1e-4;
/// Angle by which a trial turns the deviator, up to which it is taken not to turn it.
/// Unit: rad. Test: none known.
inline constexpr double little_angle = 0.005;

}  // namespace poretwin::solid::material

namespace poretwin::solid::cam_clay {

/// Change of the pressure, or of the deviator over it, that one implicit step of Cam-Clay may make by elasticity:
/// longer increments are divided. Its error falls with the square of the pressure's part and linearly with the other's.
/// Unit: the pressure. Test: CamClay.LargeStepsEndWhereSmallOnesDo (untried).
inline constexpr double longest_step = 0.05;
/// Steps of one increment at most: one that asks for more is not that of a soil that still stands.
/// Unit: steps. Test: none known (a guard).
inline constexpr double most_steps = 1e5;
/// What is left of the yield function, over pc^2, and of the plastic compression where Newton's iteration ends.
/// Unit: 1. Test: CamClay.FollowsTheTables (untried).
inline constexpr double reached = 1e-11;
/// Rounds of Newton's iteration after which a step is divided; 4 or 5 are usual.
/// Unit: rounds. Test: none known (time, not results).
inline constexpr int rounds = 15;
/// How much finer steps may become until the search is given up.
/// Unit: 1. Test: none known (a guard).
inline constexpr double finest = 256.0;

}  // namespace poretwin::solid::cam_clay

namespace poretwin::solid::element {

/// Share of what a step of a test begins with, in strains, that may be left of its conditions.
/// Unit: 1. Test: none known.
inline constexpr double reached = 1e-10;
/// Difference of strain for the numerical tangent, over the strain looked for.
/// Unit: 1. Test: none known (time, not results).
inline constexpr double probe = 1e-4;
/// Share of the largest pivot below which a direction of strain counts as without effect.
/// Unit: 1. Test: Element.CompressionEndsAtCoulombsStrengthAndDilatesByTheFlowRule (untried).
inline constexpr double singular = 1e-6;
/// Rounds of Newton's iteration of one step.
/// Unit: rounds. Test: Element.SaysWhereTheSoilBearsNoMore (untried).
inline constexpr int rounds = 60;
/// Shortest part of a correction that is tried.
/// Unit: 1. Test: none known.
inline constexpr double least_share = 0.01;

}  // namespace poretwin::solid::element
