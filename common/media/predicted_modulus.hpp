// The modulus with which water as a field predicts the volume change of soil that moves.
#pragma once

namespace poretwin::porous {

/// E over M of elastic soil, with the modulus E that a pass through a window predicts with. It is 1 in a window's first
/// pass, which is exact where the soil strains in one direction.
///
/// The strain of elastic soil under a change of the pressure is smallest where the soil strains in one direction, with
/// the constrained modulus M, and largest where it strains in all, with the bulk modulus K. A repeated pass in 3D
/// multiplies the part that was not predicted by 1 - E/M to 1 - E/K. With the harmonic mean of M and K both are equally
/// large, at most a half: (M - K) / (M + K). With E = M passes would diverge for M > 2 K, at Poisson's ratios below 0.2.
/// In 2D (plane strain) M is at most twice K + G / 3, which takes the place of K.
/// Test: FieldWithSoil.ALoadOnAPartOfAPlaneHasTheForceOfItsArea, case cryer.
inline double predicted_modulus(double poissons_ratio, int dimension, bool repeated) {
  const double bulk = (1.0 + poissons_ratio) / (3.0 * (1.0 - poissons_ratio));  // over M
  return dimension == 3 && repeated ? 2.0 * bulk / (1.0 + bulk) : 1.0;
}

}  // namespace poretwin::porous
