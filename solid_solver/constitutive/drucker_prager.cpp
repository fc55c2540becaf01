#include "solid_solver/constitutive/drucker_prager.hpp"

#include <cmath>
#include <numbers>

namespace poretwin::solid {

Cone fit_cone(double cohesion, double friction_angle, double dilation_angle, ConeMatch match) {
  const double phi = friction_angle * std::numbers::pi / 180.0, psi = dilation_angle * std::numbers::pi / 180.0;
  auto plane_strain = [](double angle) {  // alpha of Eq. (32)
    const double t = std::tan(angle);
    return t / std::sqrt(9.0 + 12.0 * t * t);
  };
  Cone cone;
  cone.alpha_psi = plane_strain(psi);
  switch (match) {
    case ConeMatch::paper: {
      const double t = std::tan(phi);
      cone.alpha = plane_strain(phi);
      cone.k = 3.0 * cohesion / std::sqrt(9.0 + 12.0 * t * t);
      break;
    }
    case ConeMatch::plane_strain: {
      const double root = std::sqrt(1.0 - 3.0 * cone.alpha_psi * cone.alpha_psi);
      cone.alpha = std::sin(phi) / (3.0 * (root + cone.alpha_psi * std::sin(phi)));
      cone.k = cohesion * std::cos(phi) * (1.0 - 3.0 * cone.alpha * cone.alpha_psi) / root;
      break;
    }
    case ConeMatch::repose:
      cone.alpha = std::tan(phi) / 3.0;
      cone.k = cohesion;
      break;
  }
  return cone;
}

double yield_function(const Tensor& stress, const Cone& cone) {
  return cone.alpha * trace(stress) + root_j2(stress) - cone.k;
}

double return_map(Tensor& stress, const Cone& cone, const Elasticity& elasticity) {
  const double i1 = trace(stress), j = root_j2(stress);
  const double f = cone.alpha * i1 + j - cone.k;
  if (f <= 0.0) return 0.0;
  const double bulk = elasticity.bulk, shear = elasticity.shear;
  const double multiplier = f / (9.0 * cone.alpha * cone.alpha_psi * bulk + shear);
  const Tensor s = deviator(stress);
  if (j > shear * multiplier) {
    stress = (1.0 - shear * multiplier / j) * s;
    const double mean = (i1 - 9.0 * bulk * cone.alpha_psi * multiplier) / 3.0;
    for (int d = 0; d < 3; ++d) stress[d] += mean;
    return multiplier / std::numbers::sqrt3;
  }
  const double apex = cone.alpha > 0.0 ? cone.k / cone.alpha : i1;
  stress.setZero();
  for (int d = 0; d < 3; ++d) stress[d] = apex / 3.0;
  return j / (shear * std::numbers::sqrt3);
}

}  // namespace poretwin::solid
