// The modulus with which water as a field predicts the volume change of soil that moves.
#pragma once

#include <algorithm>

namespace poretwin::porous {

/// Upper bound of the predicted modulus E, over the bulk modulus K, in repeated passes through a window in 3D.
///
/// The strain of elastic soil under a change of the pressure is smallest where the soil strains in one direction, with
/// the constrained modulus M, and largest with K. A repeated pass multiplies the part that was not predicted by 1 - E/M
/// to 1 - E/K. Hence passes with E = M diverge for M > 2 K, at Poisson's ratios below 0.2. With 1.6 at most 0.6 of that
/// part remains. In 2D (plane strain) M is at most twice K + G / 3, which takes the place of K.
/// Unit: 1. Test: FieldWithSoil.ALoadOnAPartOfAPlaneHasTheForceOfItsArea.
inline constexpr double most_over_bulk = 1.6;

/// E over M of elastic soil. It is 1 in a window's first pass, which is exact where the soil strains in one direction.
inline double predicted_modulus(double poissons_ratio, int dimension, bool repeated) {
  const double bulk = (1.0 + poissons_ratio) / (3.0 * (1.0 - poissons_ratio));  // over M
  return dimension == 3 && repeated ? std::min(1.0, most_over_bulk * bulk) : 1.0;
}

}  // namespace poretwin::porous
