#include "solid_solver/material/local_factor.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace poretwin::solid {

ShearSurface shear_surface(Soil::Cone fit, double dilation_angle) {
  constexpr double half_root = 0.5 * std::numbers::sqrt3;
  switch (fit) {
    case Soil::Cone::paper:
      return {1.0, 4.0 / 3.0, 0.0};
    case Soil::Cone::plane_strain: {
      const double tan_psi = std::tan(dilation_angle), flow = tan_psi / std::sqrt(9.0 + 12.0 * tan_psi * tan_psi);
      return {std::sqrt(1.0 - 3.0 * flow * flow), 1.0, flow};
    }
    case Soil::Cone::repose:
      return {1.0, 0.0, 0.0};
    case Soil::Cone::outer:
      return {half_root, 1.0, -half_root / 3.0};
    case Soil::Cone::inner:
      return {half_root, 1.0, half_root / 3.0};
  }
  return {};
}

double factor_to_yield(const ShearSurface& surface, double cohesion, double tan_phi, double tau, double p) {
  const double size = cohesion + std::abs(p) * tan_phi + std::max(tau, 0.0), strength = cohesion + p * tan_phi;
  constexpr double rounding = 1e-9;
  if (!(size > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  if (strength <= rounding * size) return tau <= rounding * size ? 1.0 : 0.0;
  if (tau <= 0.0) return std::numeric_limits<double>::infinity();
  // With tan(phi) / F in place of tan(phi): a sqrt(F^2 + b tan^2 phi) = strength / tau - d tan(phi).
  const double root = (strength / tau - surface.d * tan_phi) / surface.a;
  const double square = root * root - surface.b * tan_phi * tan_phi;
  return root > 0.0 && square > 0.0 ? std::sqrt(square) : 0.0;
}

double limit_by_tension(double factor, double tensile_strength, double tension) {
  return tensile_strength > 0.0 && tension > 0.0 ? std::min(factor, tensile_strength / tension) : factor;
}

double local_factor_of_cone(Soil::Cone fit, double cohesion, double friction_angle, double dilation_angle,
                            double tensile_strength, const Tensor& stress) {
  const double tan_phi = std::tan(friction_angle), mean = trace(stress) / 3.0, tau = root_j2(stress);
  double factor = factor_to_yield(shear_surface(fit, dilation_angle), cohesion, tan_phi, tau, -mean);
  // The friction angle falls to the dilation angle before the soil yields: from there on both are equal, and the cone
  // for plane strain is that of the paper.
  if (fit == Soil::Cone::plane_strain && factor * std::tan(dilation_angle) > tan_phi)
    factor = factor_to_yield(shear_surface(Soil::Cone::paper, 0.0), cohesion, tan_phi, tau, -mean);
  return limit_by_tension(factor, tensile_strength, mean);
}

}  // namespace poretwin::solid
