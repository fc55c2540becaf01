#include "solid_solver/constitutive/drucker_prager.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
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

namespace {

/// Share of an increment, from inside the cone to outside, that is elastic.
double elastic_share(const Tensor& s, const Tensor& ds, double radius, double change) {
  // |s + t ds|^2 = (radius + t change)^2
  const double a = contract(ds, ds) - change * change, b = contract(s, ds) - radius * change;
  const double c = contract(s, s) - radius * radius;
  if (b >= 0.0 && c >= 0.0) return 0.0;
  const double root = std::sqrt(std::max(0.0, b * b - a * c));
  const double share = b > 0.0 ? -c / (b + root) : (root - b) / a;
  return share > 0.0 && share < 1.0 ? share : 0.0;
}

/// Integral of dt / radius over the increment, the radius going linearly.
double over_radius(double from, double to) {
  const double low = std::min(from, to), high = std::max(from, to);
  if (low <= 0.0) return std::numeric_limits<double>::infinity();
  return high - low < 1e-4 * low ? 2.0 / (from + to) : std::log(high / low) / (high - low);
}

}  // namespace

double integrate(Tensor& stress, const Tensor& strain, const Cone& cone, const Elasticity& elasticity) {
  const Tensor before = stress, increment = elasticity.stress_of(strain);
  stress += increment;
  const Tensor trial = stress;
  const double plastic = return_map(stress, cone, elasticity);
  if (plastic <= 0.0) return 0.0;
  const double i1 = trace(stress), radius = std::numbers::sqrt2 * (cone.k - cone.alpha * i1);
  if (i1 >= cone.tension_limit() || radius <= 0.0) return plastic;
  const Tensor s0 = deviator(before), ds = deviator(increment);
  const double length = std::sqrt(contract(ds, ds));
  if (length <= 0.0) return plastic;
  // Only the plastic part turns the deviator.
  const double first = std::numbers::sqrt2 * (cone.k - cone.alpha * trace(before));
  const double last = std::numbers::sqrt2 * (cone.k - cone.alpha * trace(trial));
  const double elastic = elastic_share(s0, ds, first, last - first), rest = 1.0 - elastic;
  const Tensor s = s0 + elastic * ds;
  const double norm = std::sqrt(contract(s, s));
  const double start = first + elastic * (last - first);
  if (norm <= 0.0) return plastic;
  const double cosine = std::clamp(contract(s, ds) / (norm * length), -1.0, 1.0);
  // Krieg & Krieg (1977): d psi / dt = -(|ds| / radius) sin psi, hence tan(psi / 2) decays exponentially.
  const double half = std::sqrt((1.0 - cosine) / std::max(1.0 + cosine, 1e-300));
  const double left = half * std::exp(-rest * length * over_radius(start, radius));
  const double along = (1.0 - left * left) / (1.0 + left * left), across = 2.0 * left / (1.0 + left * left);
  const Tensor normal = s / norm - cosine / length * ds;
  const double size = std::sqrt(contract(normal, normal));
  stress = radius * along / length * ds;
  if (size > 1e-9) stress += radius * across / size * normal;
  for (int d = 0; d < 3; ++d) stress[d] += i1 / 3.0;
  return plastic;
}

}  // namespace poretwin::solid
