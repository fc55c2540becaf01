// Chosen numbers of the searches for equilibrium and rest. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
// Unit "travel times of a wave": the time in which an elastic wave crosses the soil's height. "Departure from rest":
// docs/theory/equilibrium.md.
#pragma once

#include <cstddef>

namespace poretwin::solid::statics {

/// Soil that cannot yield: accepted error of its stress, in the norm of the elastic energy, over the stress under
/// gravity.
/// Unit: 1. Test: Equilibrium.OfAColumnBetweenRollers (untried).
inline constexpr double elastic_error = 1e-3;
/// Fraction of elastic_error at which the search for an equilibrium ends.
/// Unit: 1. Test: none known.
inline constexpr double elastic_share = 0.2;
/// Soil that can yield: error of the stress at which the search ends, in the same norm. It is smaller, since the
/// remaining error makes such soil creep in every window.
/// Unit: 1. Test: LongWindow.EndsInEquilibrium (untried).
inline constexpr double plastic_error = 1e-4;
/// Departure from rest below which no equilibrium is searched for.
/// Unit: 1. Test: none known.
inline constexpr double negligible_unrest = 3e-3;
/// In the search's preconditioner soil has no inertia, and its walls may not fix it in place. Weak springs do: their
/// frequency.
/// Unit: of the slowest wave of a column. Test: none known.
inline constexpr double held_by_nothing = 0.03;
/// Averaged force per mass from which on a particle counts as moving.
/// Unit: gravity. Test: none known.
inline constexpr double woken_by = 5e-3;
/// Longest dynamic relaxation in a window for which no equilibrium is found.
/// Unit: travel times of a wave. Test: LongWindow.IsRefusedWhereSoilCannotStandAndTakenAgainOnceItIsCalm (untried).
inline constexpr double most_ways = 100.0;
/// Displacement of any particle at which dynamic relaxation is given up.
/// Unit: spacings. Test: none known.
inline constexpr double farthest = 0.5;

/// Departure from rest at which the search ends where its caller gives no criterion.
/// Unit: 1. Test: none known.
inline constexpr double criterion = 4e-4;
/// Largest number of trial displacements in one search.
/// Unit: displacements. Test: Equilibrium.ThatDoesNotExistLeavesTheSoilAsItWas (untried).
inline constexpr std::size_t most_tried = 300;
/// Trial displacements between two checks whether only a local part of the soil still moves.
/// Unit: displacements. Test: none known (time, not results).
inline constexpr std::size_t looks_every = 10;
/// Departure from rest of the whole soil up to which a local part may be left moving, over the search's criterion.
/// Unit: criteria. Test: none known.
inline constexpr double near_criterion = 10.0;
/// Fraction by which the moving share of the mass must decrease over four such checks; with less the search is stalled.
/// Unit: 1. Test: none known.
inline constexpr double least_gain = 0.1;
/// Share of the mass that may go on moving when the search is stalled, over the share that may otherwise.
/// Unit: 1. Test: none known.
inline constexpr double stalled_share = 2.0;

/// Change of the water's resistance up to which a factorised stiffness is used again, over the resistance that the
/// window adds and the stiffness of the slowest mode.
/// Unit: 1. Test: none known (time, not results).
inline constexpr double still_serves = 0.5;
/// Least stiffness of a pair, which keeps the matrix positive definite.
/// Unit: shear moduli. Test: none known.
inline constexpr double least_pair_stiffness = 0.1;
/// Error of the displacements that the stiffness opposes to given forces (3D), in the norm of their energy.
/// Unit: norm of these displacements. Test: Stiffness.IsSolvedInSpaceAsByFactors.
inline constexpr double inverse_accuracy = 1e-2;
/// Largest number of iterations for them.
/// Unit: iterations. Test: none known.
inline constexpr int most_inverse_iterations = 100;

/// Width of the bracket of the factor of safety at which the bisection ends, over the factor.
/// Unit: 1. Test: FactorOfSafety.OfALayerOnASlope (untried).
inline constexpr double safety_tolerance = 0.01;

/// Largest acceleration at which rest is found where the caller gives no criterion.
/// Unit: the reference acceleration. Test: Rest.ReportsItsCriterion (untried).
inline constexpr double rest_criterion = 1e-3;
/// Longest search for rest in soil that does not yield.
/// Unit: travel times of a wave. Test: none known.
inline constexpr double rest_ways = 50.0;
/// Longest search for rest once soil yields.
/// Unit: travel times of a wave. Test: none known.
inline constexpr double rest_ways_yielding = 200.0;
/// Weight of the previous damping rate against the present one once something yields: an average over about twenty
/// steps.
/// Unit: 1. Test: Sleep.DampingEndsWithTheFirstYielding (untried).
inline constexpr double damping_memory = 0.95;
/// Least damping rate once soil yields, over that of elastic soil.
/// Unit: 1. Test: none known.
inline constexpr double least_damping = 0.02;

}  // namespace poretwin::solid::statics
