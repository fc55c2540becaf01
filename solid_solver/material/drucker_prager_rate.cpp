#include "solid_solver/material/drucker_prager_rate.hpp"

#include <cmath>
#include <numbers>

namespace poretwin::solid {

double DruckerPragerRate::advance(Tensor& stress, const Tensor& strain, const Condition& condition,
                                  std::span<double> /*state*/) const {
  const Cone cone = this->cone(condition);
  Moduli<InOnes> moduli;
  elasticity_.over(stress.data(), strain.data(), moduli);
  const double bulk = moduli.bulk, shear = moduli.shear;
  const Tensor s = deviator(stress);
  const double j = root_j2(stress);
  add_stress<InOnes>(moduli, strain.data(), stress.data());
  double plastic = 0.0;
  if (cone.alpha * trace(stress) + root_j2(stress) > cone.k && j > 0.0) {
    const double driving = 3.0 * cone.alpha * bulk * trace(strain) + shear / j * contract(s, strain);
    const double multiplier = std::max(0.0, driving / (9.0 * cone.alpha * cone.alpha_psi * bulk + shear));
    stress -= multiplier * shear / j * s;
    for (int d = 0; d < 3; ++d) stress[d] -= multiplier * 3.0 * bulk * cone.alpha_psi;
    plastic = multiplier / std::numbers::sqrt3;
  }
  const double limit = cone.tension_limit();
  if (const double excess = trace(stress) - limit; excess > 0.0) {
    for (int d = 0; d < 3; ++d) stress[d] -= excess / 3.0;
    plastic = std::max(plastic, std::numeric_limits<double>::min());
  }
  const double i1 = trace(stress), bearable = cone.k - cone.alpha * i1;
  if (const double found = root_j2(stress); found > bearable) {
    stress = std::max(0.0, bearable) / found * deviator(stress);
    for (int d = 0; d < 3; ++d) stress[d] += i1 / 3.0;
    plastic += (found - std::max(0.0, bearable)) / (shear * std::numbers::sqrt3);
  }
  return plastic;
}

}  // namespace poretwin::solid
