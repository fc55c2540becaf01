// Chosen numbers of the sums over neighbouring points of water. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::fluid::points {

/// Smoothing length over the cube root (2D: square root) of the bulk volume. No reason on record.
/// Unit: spacings. Test: Operators.LaplacianOfACosineBetweenWalls (untried).
inline constexpr double smoothing_ratio = 1.3;

/// Least eigenvalue of its moment above which a particle is inside. No reason on record.
/// Unit: 1. Test: Operators.MomentsAreInvertedWhereNeighboursAreEnough (untried).
inline constexpr double inside_moment = 0.88;

/// Least eigenvalue of a moment that is inverted in full: gradients in directions with fewer neighbours are taken short
/// rather than amplified.
/// Unit: 1. Test: Operators.DirectionsWithoutNeighboursAreBlind (untried).
inline constexpr double least_inverted = 0.3;

/// Divergence of position over D from which on its departure from 1 is disorder, which the Laplacian is corrected for,
/// and no surface.
/// Unit: 1. Test: none known.
inline constexpr double disorder_from = 0.75;
/// Smallest factor by which the Laplacian is corrected for disorder; on a lattice it is off by 2.6 %.
/// Unit: 1. Test: none known.
inline constexpr double least_amplified = 0.93;
/// Largest factor by which the Laplacian is corrected for disorder.
/// Unit: 1. Test: none known.
inline constexpr double most_amplified = 1.07;

/// How far walls' images go on beyond a wall's end. No reason on record.
/// Unit: spacings. Test: none known.
inline constexpr double wall_overhang = 6.0;

/// Largest ratio of a buffer's distance behind a face to that of the particle before it, which may lie on the face.
/// Unit: 1. Test: none known.
inline constexpr double most_reflected = 30.0;

/// Sum of V W around a place below which it has no value; a flat surface has half.
/// Unit: 1. Test: none known.
inline constexpr double least_sampled = 0.3;
/// Least eigenvalue of the moment of a place's surroundings, over their weight, with which a slope is fitted.
/// Unit: 1. Test: none known.
inline constexpr double least_slope_moment = 0.02;

}  // namespace poretwin::fluid::points
