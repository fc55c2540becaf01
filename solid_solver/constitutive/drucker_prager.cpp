#include "solid_solver/constitutive/drucker_prager.hpp"

#include <cmath>
#include <numbers>

namespace poretwin::solid {

DruckerPragerSoil::DruckerPragerSoil(const Soil& soil)
    : ConstitutiveModel(Elasticity::of(soil)),
      soil_(soil),
      dilating_(fit_cone(1.0, soil.friction_angle, soil.dilation_angle, soil.cone)),
      spent_(fit_cone(1.0, soil.friction_angle, 0.0, soil.cone)) {}

Cone DruckerPragerSoil::cone(const Condition& condition) const {
  const bool dilates = !soil_.maximum_void_ratio || condition.void_ratio < *soil_.maximum_void_ratio;
  Cone cone = dilates ? dilating_ : spent_;
  cone.k *= cohesion_at(soil_, condition.saturation);
  if (soil_.tensile_strength) cone.tensile_strength = *soil_.tensile_strength;
  return cone;
}

double return_map(Tensor& stress, const Cone& cone, const Elasticity& elasticity) {
  const double i1 = trace(stress), j = root_j2(stress), limit = cone.tension_limit();
  const double f = cone.alpha * i1 + j - cone.k;
  if (f <= 0.0 && i1 <= limit) return 0.0;
  const double bulk = elasticity.bulk, shear = elasticity.shear;
  double new_i1 = limit, new_j = std::min(j, cone.k - cone.alpha * limit);
  if (f > 0.0) {
    const double multiplier = f / (9.0 * cone.alpha * cone.alpha_psi * bulk + shear);
    const double along_potential = i1 - 9.0 * bulk * cone.alpha_psi * multiplier;
    if (along_potential <= limit) {
      new_i1 = along_potential;
      new_j = j - shear * multiplier;
    }
  }
  const double mean = i1 / 3.0;
  for (int d = 0; d < 3; ++d) stress[d] -= mean;
  stress *= j > 0.0 ? new_j / j : 0.0;
  for (int d = 0; d < 3; ++d) stress[d] += new_i1 / 3.0;
  // Pure tension takes no shear; the smallest number still says that the soil yielded.
  return std::max((j - new_j) / (shear * std::numbers::sqrt3), std::numeric_limits<double>::min());
}

double integrate(Tensor& stress, const Tensor& strain, const Cone& cone, const Elasticity& elasticity) {
  constexpr double turn = 0.005;  // radians
  constexpr int most_parts = 16;
  const Tensor before = stress, increment = elasticity.stress_of(strain);
  stress += increment;
  const Tensor s0 = deviator(before), s1 = deviator(stress);
  const double plastic = return_map(stress, cone, elasticity);
  if (plastic <= 0.0) return 0.0;
  const double lengths = contract(s0, s0) * contract(s1, s1), along = contract(s0, s1);
  const double turned = lengths > 0.0 ? std::sqrt(std::max(0.0, 1.0 - along * along / lengths)) : 0.0;
  if (turned <= turn) return plastic;
  const int parts = std::min(most_parts, static_cast<int>(std::ceil(turned / turn)));
  double sum = 0.0;
  stress = before;
  for (int k = 0; k < parts; ++k) {
    stress += increment / parts;
    sum += return_map(stress, cone, elasticity);
  }
  return sum;
}

}  // namespace poretwin::solid
