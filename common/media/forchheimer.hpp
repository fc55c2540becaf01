// Darcy-Forchheimer flow, with coefficients from the case file, or from the grain size by Ergun's law.
#pragma once

#include "common/media/kozeny_carman.hpp"

namespace poretwin::porous {

/// (1 - n) / n^3: dependence of the quadratic coefficient b on the porosity n in Ergun's law.
inline double inertial_shape(double n) { return (1.0 - n) / (n * n * n); }

/// Converts a law known at one porosity to another porosity: k ~ n^3/(1-n)^2 (Kozeny-Carman), b ~ (1-n)/n^3. It is used
/// for values received from the other process, and at edges of soil, where the porosity rises to that of free water (n
/// = 1: no resistance).
inline Seepage carried_over(const Seepage& known, double known_porosity, double porosity) {
  return {known.conductivity * kozeny_carman_shape(porosity) / kozeny_carman_shape(known_porosity),
          known.quadratic * inertial_shape(porosity) / inertial_shape(known_porosity)};
}

/// The case gives both coefficients at the soil's own porosity.
inline SeepageLaw forchheimer() {
  return {"forchheimer",
          "i = U/k + b U^2",
          [](const Medium& m) {
            return carried_over({m.conductivity, m.parameters[0]}, m.own_porosity, m.porosity);
          },
          {{"forchheimer_coefficient", "s2/m2", "b at `porosity` (`forchheimer`)."}}};
}

/// Ergun (1952), Eqs. (91), (92) as corrected (their terms contain U), with the grain size D and the permeability
/// kappa: kappa = n^3 D^2 / (A (1-n)^2), k = g kappa / nu, b = B / (sqrt(A) g n^1.5 sqrt(kappa)) = B (1-n) / (g n^3 D).
/// A = 150 and B = 1.75 unless the case gives other values.
inline SeepageLaw ergun() {
  return {"ergun",
          "k and b from the grains, Eqs. (91), (92) as corrected",
          [](const Medium& m) {
            const double n = m.porosity, D = m.parameters[0], A = m.parameters[1], B = m.parameters[2];
            const double kappa = n * n * n * D * D / (A * (1.0 - n) * (1.0 - n));
            return Seepage{m.gravity * kappa / m.viscosity, B * inertial_shape(n) / (m.gravity * D)};
          },
          {{"grain_diameter", "m", "Mean diameter of the grains, D50 (`ergun`, mu_i).", 0.0, true},
           {"ergun_linear", "", "Ergun's 150, of the linear term (`ergun`).", 150.0, true},
           {"ergun_quadratic", "", "Ergun's 1.75, of the quadratic term (`ergun`).", 1.75}},
          false};
}

}  // namespace poretwin::porous
