// Chosen numbers of the searches for equilibrium and rest. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

#include <cstddef>

namespace poretwin::solid::statics {

/// Soil that cannot yield: error of its stress, in the energy's norm and over that under gravity, that is accepted.
/// Unit: 1. Test: Equilibrium.OfAColumnBetweenRollers (untried).
inline constexpr double elastic_error = 1e-3;
/// Fraction of elastic_error at which the search for an equilibrium ends.
/// Unit: 1. Test: none known.
inline constexpr double elastic_share = 0.2;
/// Soil that can yield: error of the stress that ends the search, since soil creeps by what is left in every window.
/// Unit: 1. Test: LongWindow.EndsInEquilibrium (untried).
inline constexpr double plastic_error = 1e-4;
/// Departure from rest, over gravity, below which no equilibrium is sought at all.
/// Unit: 1. Test: none known.
inline constexpr double negligible_unrest = 3e-3;
/// Frequency of the springs that hold soil without inertia in the search's preconditioner, where its walls may not.
/// Unit: of the slowest wave of a column. Test: none known.
inline constexpr double held_by_nothing = 0.03;
/// Averaged force on a particle from which on it counts as moving.
/// Unit: gravity. Test: none known.
inline constexpr double woken_by = 5e-3;
/// Longest dynamic relaxation where no equilibrium is found.
/// Unit: ways of a wave. Test: LongWindow.IsRefusedWhereSoilCannotStandAndTakenAgainOnceItIsCalm (untried).
inline constexpr double most_ways = 100.0;
/// Displacement of soil beyond which dynamic relaxation is given up.
/// Unit: spacings. Test: none known.
inline constexpr double farthest = 0.5;

/// Criterion of the search where none is asked for, as a departure from rest.
/// Unit: 1. Test: none known.
inline constexpr double criterion = 4e-4;
/// Displacements tried in one search, at most.
/// Unit: displacements. Test: Equilibrium.ThatDoesNotExistLeavesTheSoilAsItWas (untried).
inline constexpr std::size_t most_tried = 300;
/// Displacements tried between two checks whether only a local part still moves.
/// Unit: displacements. Test: none known (time, not results).
inline constexpr std::size_t looks_every = 10;
/// Departure from rest of all the soil up to which a local part may be left moving.
/// Unit: criteria. Test: none known.
inline constexpr double near_criterion = 10.0;
/// Decrease of the moving share over four such checks below which trying on gains nothing.
/// Unit: 1. Test: none known.
inline constexpr double least_gain = 0.1;
/// Share of the mass that may go on moving when trying on gains nothing, over the share that may otherwise.
/// Unit: 1. Test: none known.
inline constexpr double stalled_share = 2.0;

/// Change of what the water resists with, over all that a window adds and the slowest mode's stiffness, up to which a
/// factorised stiffness still serves.
/// Unit: 1. Test: none known (time, not results).
inline constexpr double still_serves = 0.5;
/// Least stiffness of a pair, which keeps the matrix positive.
/// Unit: shear moduli. Test: none known.
inline constexpr double least_pair_stiffness = 0.1;

/// Width of a bracket of the factor of safety, over the factor.
/// Unit: 1. Test: FactorOfSafety.OfALayerOnASlope (untried).
inline constexpr double safety_tolerance = 0.01;

/// Criterion of rest where none is asked for, for the largest acceleration.
/// Unit: the reference acceleration. Test: Rest.ReportsItsCriterion (untried).
inline constexpr double rest_criterion = 1e-3;
/// Longest search for rest.
/// Unit: ways of a wave. Test: none known.
inline constexpr double rest_ways = 50.0;
/// Longest search for rest once soil yields.
/// Unit: ways of a wave. Test: none known.
inline constexpr double rest_ways_yielding = 200.0;
/// Weight of the damping so far against a new rate, once something yields: an average over about twenty steps.
/// Unit: 1. Test: Sleep.DampingEndsWithTheFirstYielding (untried).
inline constexpr double damping_memory = 0.95;
/// Least damping once soil yields, over that of elastic soil.
/// Unit: 1. Test: none known.
inline constexpr double least_damping = 0.02;

}  // namespace poretwin::solid::statics
