// What a skeleton of grains does to the water that flows through it: one law of seepage for both phases.
#pragma once

#include "common/case/case.hpp"
#include "common/media/forchheimer.hpp"

namespace poretwin::porous {

/// Force per volume on the water, against its relative velocity w = v_w - v_s: R = (linear + quadratic |w|) w.
struct Resistance {
  double linear = 0.0;     ///< gamma_w n^2 / k, first term of Eq. (18), N s/m4
  double quadratic = 0.0;  ///< gamma_w n^3 b, second term of Eq. (91) as corrected, N s2/m5
  /// |R| / |w|, N s/m4.
  [[nodiscard]] double coefficient(double speed) const { return linear + quadratic * speed; }
  /// dR/d|w| along the flow, N s/m4.
  [[nodiscard]] double slope(double speed) const { return linear + 2.0 * quadratic * speed; }
  /// |w| at which |R| = force [N/m3].
  [[nodiscard]] double speed(double force) const;
};

/// Specific weight [N/m3] behind the word "conductivity": that of the case's gravity, or of 9.81 m/s2 where there is
/// none.
double specific_weight(const Case& scene);

/// The value of a law's parameter in a soil: the case's, or the law's own.
double parameter(const Soil& soil, const LawParameter& parameter);

/// The soil's law at a porosity; gravity [m/s2]: the one behind the word "conductivity"; viscosity of the water [m2/s].
Seepage seepage_at(const Soil& soil, double porosity, double gravity, double viscosity);
Seepage seepage_at(const Case& scene, const Soil& soil, double porosity);

/// Conductivity of the fastest soil over that of the slowest, each at its own porosity; 1 without soil. Below
/// `one_conductivity` they are the same but for rounding.
double conductivity_contrast(const Case& scene);
inline constexpr double one_conductivity = 1.0 + 1e-9;

Resistance resistance(double specific_weight, double porosity, const Seepage& seepage);

}  // namespace poretwin::porous
