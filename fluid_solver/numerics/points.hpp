// Chosen numbers of the sums over neighbouring points of water. What an entry needs: CONTRIBUTING.md.
// Symbols: V bulk volume, W kernel. The divergence of position is sum V_b (x_b - x_a).grad W.
// (untried) behind a test's name: the test has not yet been seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::fluid::points {

/// Smoothing length over the particle spacing. The spacing is the cube root (2D: square root) of the bulk volume. The
/// reason for the value is not on record.
/// Unit: spacings. Test: Operators.LaplacianOfACosineBetweenWalls (untried).
inline constexpr double smoothing_ratio = 1.3;

/// A particle counts as inside the water where the least eigenvalue of its moment matrix exceeds this value. The reason
/// for the value is not on record.
/// Unit: 1. Test: Operators.MomentsAreInvertedWhereNeighboursAreEnough (untried).
inline constexpr double inside_moment = 0.88;

/// A moment matrix is inverted as it is where its least eigenvalue is at least this value. In directions with fewer
/// neighbours the gradients are then too small, rather than amplified.
/// Unit: 1. Test: Operators.DirectionsWithoutNeighboursAreBlind (untried).
inline constexpr double least_inverted = 0.3;

/// A slope of the pressure is fitted to a particle's pairs with others where the least eigenvalue of their moment, over
/// that inside the water, is at least this. It is 0.5 in the row along a wall or a surface and 0.25 in a corner.
/// Unit: 1. Test: Operators.PairsShowNoLinearPressureAndAllOfAnAlternatingOne (untried).
inline constexpr double least_pair_moment = 0.1;

/// Where the divergence of position over the number of dimensions exceeds this value, its difference from 1 counts as
/// disorder, for which the Laplacian is corrected. A particle with a lower value lies at a surface.
/// Unit: 1. Test: none known.
inline constexpr double disorder_from = 0.75;
/// Lower bound of the divergence of position over the number of dimensions in the correction of the Laplacian. On a
/// lattice the uncorrected Laplacian is off by 2.6 %.
/// Unit: 1. Test: none known.
inline constexpr double least_amplified = 0.93;
/// Upper bound of the divergence of position over the number of dimensions in that correction.
/// Unit: 1. Test: none known.
inline constexpr double most_amplified = 1.07;

/// Length by which the images behind a wall continue beyond its end. The reason for the value is not on record.
/// Unit: spacings. Test: none known.
inline constexpr double wall_overhang = 6.0;

/// Upper bound of the ratio d_b / d_a with which a particle's pressure is reflected in a face: d_b is the distance of
/// the buffer behind the face, d_a that of the particle in front of it, which is 0 for a particle on the face.
/// Unit: 1. Test: none known.
inline constexpr double most_reflected = 30.0;

/// No value is interpolated where the sum of V W is below this. On a flat surface of water the sum is a half.
/// Unit: 1. Test: none known.
inline constexpr double least_sampled = 0.3;
/// A slope is fitted around a place where the least eigenvalue of the moment matrix, over its weight, is at least this.
/// Unit: 1. Test: none known.
inline constexpr double least_slope_moment = 0.02;

}  // namespace poretwin::fluid::points
