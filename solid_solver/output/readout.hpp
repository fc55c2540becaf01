// Quantities derived from a stress state.
#pragma once

#include "solid_solver/material/model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace poretwin::solid {

/// Mobilised friction angle [degrees], sin phi_m = (s1 - s3) / (s1 + s3) with the largest and smallest principal
/// compression s1 and s3; independent of the strength. 90 where a principal stress is tensile, 0 without stress.
inline double mobilised_friction(const Tensor& stress) {
  const auto [largest, smallest] = extreme_stresses(stress);
  const double most = -smallest, least = -largest;
  if (most == least) return 0.0;
  const double sine = least > 0.0 ? (most - least) / (most + least) : 1.0;
  return std::asin(std::clamp(sine, 0.0, 1.0)) * 180.0 / std::numbers::pi;
}

/// Pore-pressure ratio r_u = p / sigma_v [1]: pore pressure over total vertical stress, both positive in compression; 1
/// means liquefied. Zero without vertical compression. vertical: effective stress along gravity [Pa], compression
/// negative.
inline double pore_pressure_ratio(double pressure, double vertical) {
  const double total = pressure - vertical;
  return total > 0.0 ? pressure / total : 0.0;
}

/// Elastic energy per volume [J/m3]: p^2 / (2 K) + J2 / (2 G), with the mean stress p and the moduli K and G.
inline double strain_energy(const Tensor& stress, const Elasticity& elasticity) {
  const double mean = trace(stress) / 3.0, j = root_j2(stress);
  return 0.5 * (mean * mean / elasticity.bulk + j * j / elasticity.shear);
}

}  // namespace poretwin::solid
