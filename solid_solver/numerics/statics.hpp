// Chosen numbers of the searches for equilibrium and rest. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test's name: the test has not yet been seen to fail when the number is halved or doubled.
// Unit "travel times of a wave": the time in which an elastic wave crosses the soil's height. "Departure from rest":
// docs/theory/equilibrium.md.
#pragma once

#include <cstddef>

namespace poretwin::solid::statics {

/// Accepted error of the stress in soil that cannot yield. It is relative to the stress under gravity, in the norm of
/// the elastic energy.
/// Unit: 1. Test: none known.
inline constexpr double elastic_error = 1e-3;
/// In soil that cannot yield the search for an equilibrium ends at this fraction of elastic_error.
/// Unit: 1. Test: none known.
inline constexpr double elastic_share = 0.2;
/// Error of the stress at which the search ends in soil that can yield, in the norm of elastic_error. It is smaller,
/// since the remaining error makes such soil creep in every window.
/// Unit: 1. Test: none known.
inline constexpr double plastic_error = 1e-4;
/// No equilibrium is searched for where the departure from rest is below this value.
/// Unit: 1. Test: none known.
inline constexpr double negligible_unrest = 3e-3;
/// The search's preconditioner includes no inertia of the soil, and the walls may leave the soil free to move. Weak
/// springs then constrain the soil. This is their angular frequency sqrt(stiffness / mass).
/// Unit: the near-critical damping rate, 2 omega of the slowest wave of a column. Test: none known.
inline constexpr double held_by_nothing = 0.03;
/// A particle counts as moving where its averaged force per mass is at least this value.
/// Unit: the reference acceleration. Test: none known.
inline constexpr double woken_by = 5e-3;
/// Longest time of dynamic relaxation, in a window for which the search finds no equilibrium.
/// Unit: travel times of a wave. Test: none known.
inline constexpr double most_ways = 100.0;
/// Dynamic relaxation, and the search for an equilibrium at the end of a window, are given up once any particle is
/// displaced by this length.
/// Unit: spacings. Test: none known.
inline constexpr double farthest = 0.5;
/// In soil that cannot yield, the search at the end of a window may displace a particle by this much if that is more.
/// Under a sudden load on soil full of water as a field, the first pass tries the settlement of drained soil.
/// Unit: heights of the soil. Test: FieldWithSoil.BearsLoadsUnderWhichItSettlesByMuchOfASpacing (untried).
inline constexpr double farthest_elastic = 0.1;

/// The search ends at this departure from rest where its caller gives no criterion.
/// Unit: 1. Test: none known.
inline constexpr double criterion = 4e-4;
/// Largest number of trial displacements in one search.
/// Unit: displacements. Test: none known.
inline constexpr std::size_t most_tried = 300;
/// Number of trial displacements after which it is checked whether only a local part of the soil still moves.
/// Unit: displacements. Test: none known (time, not results).
inline constexpr std::size_t looks_every = 10;
/// A local part may keep moving while the whole soil's departure from rest, over the criterion, is below this.
/// Unit: criteria. Test: none known.
inline constexpr double near_criterion = 10.0;
/// The search is stalled where the moving fraction of the mass decreases by less than this over four such checks.
/// Unit: 1. Test: none known.
inline constexpr double least_gain = 0.1;
/// When the search is stalled, the fraction of the mass that may continue to move is larger by this factor.
/// Unit: 1. Test: none known.
inline constexpr double stalled_share = 2.0;

/// A factorised stiffness is used again while the change of the water's resistance, over the sum of the resistance that
/// the window adds and the stiffness of the slowest mode, is at most this value.
/// Unit: 1. Test: none known (time, not results).
inline constexpr double still_serves = 0.5;
/// Least stiffness of a pair, which keeps the matrix positive definite.
/// Unit: shear moduli. Test: none known.
inline constexpr double least_pair_stiffness = 0.1;
/// Error to which displacements under given forces are solved for with the stiffness (3D), in the norm of their energy.
/// Unit: norm of these displacements. Test: Stiffness.IsSolvedInSpaceAsByFactors.
inline constexpr double inverse_accuracy = 1e-2;
/// Largest number of iterations in this solve.
/// Unit: iterations. Test: none known.
inline constexpr int most_inverse_iterations = 100;

/// The bisection for the factor of safety ends where the width of the bracket, over the factor, falls to this value.
/// Unit: 1. Test: FactorOfSafety.OfALayerOnASlope.
inline constexpr double safety_tolerance = 0.01;

/// Soil counts as at rest where the largest acceleration is below this value, unless the caller gives a criterion.
/// Unit: the reference acceleration. Test: Rest.ReportsItsCriterion.
inline constexpr double rest_criterion = 1e-3;
/// Longest time of the search for rest in soil that does not yield.
/// Unit: travel times of a wave. Test: none known.
inline constexpr double rest_ways = 50.0;
/// Longest time of the search for rest once soil yields.
/// Unit: travel times of a wave. Test: none known.
inline constexpr double rest_ways_yielding = 200.0;
/// Weight of the previous damping rate in its average with the present rate once something yields. The average extends
/// over about twenty steps.
/// Unit: 1. Test: none known.
inline constexpr double damping_memory = 0.95;
/// Least damping rate once soil yields, over that of elastic soil.
/// Unit: 1. Test: none known.
inline constexpr double least_damping = 0.02;

}  // namespace poretwin::solid::statics
