// Resistance of soil to the water that flows through it. Both phases use the same seepage law.
#pragma once

#include "common/case/case.hpp"
#include "common/media/forchheimer.hpp"

namespace poretwin::porous {

/// Force R per volume that resists the water, with its relative velocity w = v_w - v_s: R = (linear + quadratic |w|) w.
struct Resistance {
  double linear = 0.0;     ///< gamma_w n^2 / k, first term of Eq. (18), N s/m4
  double quadratic = 0.0;  ///< gamma_w n^3 b, second term of Eq. (91) as corrected, N s2/m5
  /// |R| / |w|, N s/m4, at the speed |w| [m/s].
  [[nodiscard]] double coefficient(double speed) const { return linear + quadratic * speed; }
  /// d|R| / d|w|, N s/m4.
  [[nodiscard]] double slope(double speed) const { return linear + 2.0 * quadratic * speed; }
  /// |w| [m/s] for which |R| = force [N/m3].
  [[nodiscard]] double speed(double force) const;
};

/// Specific weight of the water [N/m3] for which conductivities are given: with the case's gravity, or with 9.81 m/s2
/// if the case has no gravity.
double specific_weight(const Case& scene);

/// Outward hydraulic gradient at which water that leaves a soil upwards lifts its grains: the grains' buoyant weight
/// over the weight of water of the same bulk volume, (1 - n) (rho_s / rho_w - 1) (Terzaghi 1922).
double critical_gradient(const Case& scene, const Soil& soil);

/// The value of a law's parameter in a soil: the value in the case, otherwise the default.
double parameter(const Soil& soil, const LawParameter& parameter);

/// The seepage law of a soil at a porosity. gravity [m/s2]: for which conductivities are given; viscosity [m2/s]:
/// kinematic viscosity of the water.
Seepage seepage_at(const Soil& soil, double porosity, double gravity, double viscosity);
Seepage seepage_at(const Case& scene, const Soil& soil, double porosity);

/// Largest conductivity over the smallest, each at the soil's own porosity; 1 without soil. Below `one_conductivity`
/// all conductivities are equal up to rounding.
double conductivity_contrast(const Case& scene);
inline constexpr double one_conductivity = 1.0 + 1e-9;

Resistance resistance(double specific_weight, double porosity, const Seepage& seepage);

}  // namespace poretwin::porous
