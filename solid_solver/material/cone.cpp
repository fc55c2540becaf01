#include "solid_solver/material/cone.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace poretwin::solid {

Cone fit_cone(double cohesion, double friction_angle, double dilation_angle, Soil::Cone fit) {
  const double phi = friction_angle * std::numbers::pi / 180.0, psi = dilation_angle * std::numbers::pi / 180.0;
  const double sin_phi = std::sin(phi), cos_phi = std::cos(phi), tan_phi = std::tan(phi), tan_psi = std::tan(psi);
  Cone cone;
  // In plane strain at the limit state, this alpha_psi makes the flow rule dilate by psi, whichever cone is fitted.
  cone.alpha_psi = tan_psi / std::sqrt(9.0 + 12.0 * tan_psi * tan_psi);
  switch (fit) {
    case Soil::Cone::paper:
      cone.alpha = tan_phi / std::sqrt(9.0 + 12.0 * tan_phi * tan_phi);
      cone.k = 3.0 * cohesion / std::sqrt(9.0 + 12.0 * tan_phi * tan_phi);
      break;
    case Soil::Cone::plane_strain: {
      const double root = std::sqrt(1.0 - 3.0 * cone.alpha_psi * cone.alpha_psi);
      cone.alpha = sin_phi / (3.0 * (root + cone.alpha_psi * sin_phi));
      cone.k = cohesion * cos_phi * (1.0 - 3.0 * cone.alpha * cone.alpha_psi) / root;
      break;
    }
    case Soil::Cone::repose:
      cone.alpha = tan_phi / 3.0;
      cone.k = cohesion;
      break;
    case Soil::Cone::outer:
    case Soil::Cone::inner: {
      const double sign = fit == Soil::Cone::outer ? -1.0 : 1.0;
      const double edge = std::numbers::sqrt3 * (3.0 + sign * sin_phi), sin_psi = std::sin(psi);
      cone.alpha = 2.0 * sin_phi / edge;
      cone.k = 6.0 * cohesion * cos_phi / edge;
      cone.alpha_psi = 2.0 * sin_psi / (std::numbers::sqrt3 * (3.0 + sign * sin_psi));
      break;
    }
  }
  return cone;
}

Soil weakened(Soil soil, double factor, const std::vector<MaterialKey>& own) {
  constexpr double degree = std::numbers::pi / 180.0;
  soil.cohesion /= factor;
  if (soil.saturated_cohesion) *soil.saturated_cohesion /= factor;
  if (soil.tensile_strength) *soil.tensile_strength /= factor;
  if (soil.residual_cohesion) *soil.residual_cohesion /= factor;
  const auto reduce = [&](double& angle) { angle = std::atan(std::tan(angle * degree) / factor) / degree; };
  reduce(soil.friction_angle);
  if (soil.residual_friction_angle) reduce(*soil.residual_friction_angle);
  soil.dilation_angle = std::min(soil.dilation_angle, soil.friction_angle);
  if (soil.residual_dilation_angle)
    *soil.residual_dilation_angle = std::min({*soil.residual_dilation_angle, soil.dilation_angle,
                                              soil.residual_friction_angle.value_or(soil.friction_angle)});
  for (const MaterialKey& key : own)
    if (key.strength) soil.own_numbers.at(std::string(key.name)) /= factor;
  return soil;
}

}  // namespace poretwin::solid
