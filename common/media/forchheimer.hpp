// Darcy-Forchheimer flow: coefficients of the case file, or Ergun's from the size of the grains.
#pragma once

#include "common/media/seepage.hpp"

namespace poretwin::porous {

/// (1 - n) / n^3: how the quadratic coefficient follows the porosity in Ergun's law.
inline double inertial_shape(double n) { return (1.0 - n) / (n * n * n); }

/// Both coefficients given at the soil's own porosity.
inline Seepage forchheimer(const Soil& soil, double n) {
  return carried_over({soil.hydraulic_conductivity, soil.forchheimer_coefficient}, soil.porosity, n);
}

/// Ergun (1952), Eqs. (91), (92) as corrected (the terms belong to U): kappa = n^3 D^2 / (A (1-n)^2), k = g kappa / nu,
/// b = B / (sqrt(A) g n^1.5 sqrt(kappa)) = B (1-n) / (g n^3 D); A = 150 and B = 1.75 unless the case says otherwise.
inline Seepage ergun(const Soil& soil, double gravity, double kinematic_viscosity, double n) {
  const double D = soil.grain_diameter;
  const double kappa = n * n * n * D * D / (soil.ergun_linear * (1.0 - n) * (1.0 - n));
  return {gravity * kappa / kinematic_viscosity, soil.ergun_quadratic * inertial_shape(n) / (gravity * D)};
}

}  // namespace poretwin::porous
