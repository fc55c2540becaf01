// The modulus with which water as a field predicts the volume of soil that moves.
#pragma once

#include <algorithm>

namespace poretwin::porous {

/// Upper bound of that modulus E in repeated passes through a window in 3D, over the bulk modulus K.
///
/// The strain that a change of the pressure causes in elastic soil lies between that over the constrained modulus M,
/// where the soil strains in one direction, and that over K. A repeated pass multiplies what was not foreseen by 1 -
/// E/M to 1 - E/K, so that passes diverge for E = M > 2 K, at Poisson's ratios below 0.2. With 1.6 they leave 0.6 of it
/// at most. In 2D (plane strain) M is at most twice the modulus K + G / 3 that takes the place of K. Unit: 1. Test:
/// FieldWithSoil.ALoadOnAPartOfAPlaneHasTheForceOfItsArea.
inline constexpr double most_over_bulk = 1.6;

/// E over M of elastic soil: 1 in a window's first pass, which is exact where the soil strains in one direction.
inline double predicted_modulus(double poissons_ratio, int dimension, bool repeated) {
  const double bulk = (1.0 + poissons_ratio) / (3.0 * (1.0 - poissons_ratio));  // over M
  return dimension == 3 && repeated ? std::min(1.0, most_over_bulk * bulk) : 1.0;
}

}  // namespace poretwin::porous
