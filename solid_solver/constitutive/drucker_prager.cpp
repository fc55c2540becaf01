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

namespace {

/// Brings invariants outside the cone back; returns the equivalent deviatoric plastic strain (0 inside).
double return_invariants(double& i1, double& j, const Cone& cone, const Elasticity& elasticity) {
  const double limit = cone.tension_limit(), f = cone.alpha * i1 + j - cone.k;
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
  // Pure tension takes no shear; the smallest number still says that the soil yielded.
  const double plastic = std::max((j - new_j) / (shear * std::numbers::sqrt3), std::numeric_limits<double>::min());
  i1 = new_i1;
  j = new_j;
  return plastic;
}

/// Share of an increment, from inside the cone to outside, that is elastic: |s + t ds| = radius + t change; from the
/// products s.s, s.ds and ds.ds.
double elastic_share(double ss, double sd, double dd, double radius, double change) {
  const double a = dd - change * change, b = sd - radius * change, c = ss - radius * radius;
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

double return_map(Tensor& stress, const Cone& cone, const Elasticity& elasticity) {
  double i1 = trace(stress), j = root_j2(stress);
  const double mean = i1 / 3.0, before = j;
  const double plastic = return_invariants(i1, j, cone, elasticity);
  if (plastic <= 0.0) return 0.0;
  for (int d = 0; d < 3; ++d) stress[d] -= mean;
  stress *= before > 0.0 ? j / before : 0.0;
  for (int d = 0; d < 3; ++d) stress[d] += i1 / 3.0;
  return plastic;
}

double integrate(Tensor& stress, const Tensor& strain, const Cone& cone, const Elasticity& elasticity) {
  using std::numbers::sqrt2;
  constexpr double little = 0.005;  // radians
  // Deviators before, their increment, and their elastic sum; plain numbers stay in registers.
  double s[6], ds[6];
  const double mean = trace(stress) / 3.0, volumetric = trace(strain);
  for (int d = 0; d < 6; ++d) {
    s[d] = stress[d] - (d < 3 ? mean : 0.0);
    ds[d] = 2.0 * elasticity.shear * (strain[d] - (d < 3 ? volumetric / 3.0 : 0.0));
  }
  auto product = [](const double* a, const double* b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + 2.0 * (a[3] * b[3] + a[4] * b[4] + a[5] * b[5]);
  };
  const double ss = product(s, s), sd = product(s, ds), dd = product(ds, ds), trial = ss + 2.0 * sd + dd;
  const double i1_before = 3.0 * mean, i1_trial = i1_before + 3.0 * elasticity.bulk * volumetric;
  double i1 = i1_trial;
  auto set = [&](double old_part, double new_part) {
    for (int d = 0; d < 6; ++d) stress[d] = old_part * s[d] + new_part * ds[d] + (d < 3 ? i1 / 3.0 : 0.0);
  };
  // Inside the cone, hence below its apex: without a root or a division.
  const double room = cone.k - cone.alpha * i1_trial;
  if (room >= 0.0 && trial <= 2.0 * room * room && i1_trial <= 3.0 * cone.tensile_strength) {
    set(1.0, 1.0);
    return 0.0;
  }
  const double j_trial = std::sqrt(0.5 * std::max(0.0, trial));
  double j = j_trial;
  const double plastic = return_invariants(i1, j, cone, elasticity);
  const double along_trial = ss + sd;  // s . (s + ds)
  const bool turns = ss * trial - along_trial * along_trial > little * little * ss * trial;
  if (plastic <= 0.0 || !turns || i1 >= cone.tension_limit() || j <= 0.0) {
    const double scale = plastic <= 0.0 ? 1.0 : j_trial > 0.0 ? j / j_trial : 0.0;
    set(scale, scale);
    return plastic;
  }
  // Only the plastic part turns the deviator: the radius of the cone as elastic strain would have it, and as it is.
  const double first = sqrt2 * (cone.k - cone.alpha * i1_before), last = sqrt2 * (cone.k - cone.alpha * i1_trial);
  const double elastic = elastic_share(ss, sd, dd, first, last - first);
  const double norm = std::sqrt(ss + elastic * (2.0 * sd + elastic * dd)), length = std::sqrt(dd);
  const double cosine = std::clamp((sd + elastic * dd) / (norm * length), -1.0, 1.0);
  const double sine = std::sqrt(1.0 - cosine * cosine);
  // Krieg & Krieg (1977): d psi / dt = -(|ds| / radius) sin psi, hence tan(psi / 2) decays exponentially.
  const double start = first + elastic * (last - first), end = sqrt2 * j;
  const double half = sine / std::max(1.0 + cosine, 1e-12);
  const double left = half * std::exp(-(1.0 - elastic) * length * over_radius(start, end));
  const double along = (1.0 - left * left) / (1.0 + left * left), across = 2.0 * left / (1.0 + left * left);
  // Unit vectors: ds / length, and ((s + elastic ds) / norm - cosine ds / length) / sine across it.
  const double tilt = sine > 1e-9 ? end * across / (sine * norm) : 0.0;
  set(tilt, tilt * elastic + (end * along - tilt * norm * cosine) / length);
  return plastic;
}

}  // namespace poretwin::solid
