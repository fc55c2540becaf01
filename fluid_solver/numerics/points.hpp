// Chosen numbers of the sums over neighbouring points of water. What an entry needs: CONTRIBUTING.md.
// Symbols: V bulk volume, W kernel. The divergence of position is sum V_b (x_b - x_a).grad W.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::fluid::points {

/// Smoothing length over the particle spacing, the cube root (2D: square root) of the bulk volume. The reason for the
/// value is not on record.
/// Unit: spacings. Test: Operators.LaplacianOfACosineBetweenWalls (untried).
inline constexpr double smoothing_ratio = 1.3;

/// Least eigenvalue of the moment matrix above which a particle counts as inside the water. The reason for the value is
/// not on record.
/// Unit: 1. Test: Operators.MomentsAreInvertedWhereNeighboursAreEnough (untried).
inline constexpr double inside_moment = 0.88;

/// Least eigenvalue of a moment matrix that is inverted as it is. In directions with fewer neighbours gradients are too
/// small rather than amplified.
/// Unit: 1. Test: Operators.DirectionsWithoutNeighboursAreBlind (untried).
inline constexpr double least_inverted = 0.3;

/// Least eigenvalue of the moment of a particle's pairs with other particles, over that inside the water, with which a
/// slope of the pressure is fitted to them. It is 0.5 in the row along a wall or a surface and 0.25 in a corner.
/// Unit: 1. Test: Operators.PairsShowNoLinearPressureAndAllOfAnAlternatingOne (untried).
inline constexpr double least_pair_moment = 0.1;

/// Divergence of position over the number of dimensions from which on a difference from 1 counts as disorder, for which
/// the Laplacian is corrected. Below it lies a surface.
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

/// Upper bound of d_b / d_a, with which a particle's pressure is reflected in a face: distance d_b of the buffer behind
/// the face over distance d_a of the particle in front of it. A particle may lie on the face, d_a = 0.
/// Unit: 1. Test: none known.
inline constexpr double most_reflected = 30.0;

/// No value is interpolated where the sum of V W is below this. On a flat surface of water the sum is a half.
/// Unit: 1. Test: none known.
inline constexpr double least_sampled = 0.3;
/// Least eigenvalue of the moment matrix around a place, over its weight, with which a slope is fitted.
/// Unit: 1. Test: none known.
inline constexpr double least_slope_moment = 0.02;

}  // namespace poretwin::fluid::points
