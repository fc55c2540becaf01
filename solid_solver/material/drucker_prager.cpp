#include "solid_solver/material/drucker_prager.hpp"

#include "solid_solver/material/local_factor.hpp"
#include "solid_solver/numerics/material.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace poretwin::solid {

DruckerPragerSoil::DruckerPragerSoil(const Soil& soil)
    : elasticity_(soil),
      soil_(soil),
      dilating_(fit_cone(1.0, soil.friction_angle, soil.dilation_angle, soil.cone)),
      spent_(fit_cone(1.0, soil.friction_angle, 0.0, soil.cone)) {}

Cone DruckerPragerSoil::cone(const Condition& condition) const {
  Cone cone = can_dilate(condition) ? dilating_ : spent_;
  cone.k *= cohesion_at(soil_, condition.saturation);
  if (soil_.tensile_strength) cone.tensile_strength = *soil_.tensile_strength;
  return cone;
}

double DruckerPragerSoil::local_factor(const Tensor& stress, const Condition& condition,
                                       std::span<const double> /*state*/) const {
  constexpr double degree = std::numbers::pi / 180.0;
  return local_factor_of_cone(soil_.cone, cohesion_at(soil_, condition.saturation), degree * soil_.friction_angle,
                              can_dilate(condition) ? degree * soil_.dilation_angle : 0.0,
                              soil_.tensile_strength.value_or(0.0), stress);
}

namespace {

// The functions below treat one particle (In = InOnes) or four at a time (InFours).

/// The constants of Cone, for one particle or four.
template <class In>
struct Cones {
  using Number = typename In::Number;
  Number alpha, alpha_psi, k;
  double tensile_strength;
  [[gnu::always_inline]] void tension_limit(Number& limit) const {
    limit = Number{} + 3.0 * tensile_strength;
    const Number apex = k / alpha;
    limit = ((alpha > 0.0) & (apex < limit)) ? apex : limit;
  }
};

/// Returns a stress outside the cone to the cone, given its invariants I1 (i1) and sqrt(J2) (j). Computes the
/// equivalent deviatoric plastic strain (0 inside the cone).
template <class In>
[[gnu::always_inline]] inline void return_invariants(typename In::Number& i1, typename In::Number& j,
                                                     const Cones<In>& cone, const Moduli<In>& elasticity,
                                                     typename In::Number& plastic) {
  using Number = typename In::Number;
  const Number bulk = elasticity.bulk, shear = elasticity.shear;
  Number limit;
  cone.tension_limit(limit);
  const Number f = cone.alpha * i1 + j - cone.k, multiplier = f / (9.0 * bulk * cone.alpha * cone.alpha_psi + shear);
  const Number along_potential = i1 - 9.0 * bulk * cone.alpha_psi * multiplier;
  Number new_j = cone.k - cone.alpha * limit;
  min_in_place(new_j, j);
  const typename In::Mask onto_cone = (f > 0.0) & (along_potential <= limit);
  new_j = onto_cone ? j - shear * multiplier : new_j;
  // In pure tension nothing yields in shear: the smallest positive number marks that the soil yielded.
  plastic = (j - new_j) / (shear * std::numbers::sqrt3);
  max_in_place(plastic, Number{} + std::numeric_limits<double>::min());
  const typename In::Mask yields = (f > 0.0) | (i1 > limit);
  plastic = yields ? plastic : Number{};
  j = yields ? new_j : j;
  i1 = yields ? (onto_cone ? along_potential : limit) : i1;
}

/// Elastic fraction t of an increment from inside the cone to outside: |s + t ds| = radius + t change, given the
/// products s.s (ss), s.ds (sd) and ds.ds (dd) of the deviator s and its increment ds.
template <class In>
[[gnu::always_inline]] inline void elastic_share(const typename In::Number& ss, const typename In::Number& sd,
                                                 const typename In::Number& dd, const typename In::Number& radius,
                                                 const typename In::Number& change, typename In::Number& share) {
  using Number = typename In::Number;
  const Number a = dd - change * change, b = sd - radius * change, c = ss - radius * radius;
  Number root = b * b - a * c;
  max_in_place(root, Number{});
  sqrt_in_place(root);
  const typename In::Mask grows = b > 0.0;
  share = (grows ? -c : root - b) / (grows ? b + root : a);
  share = (((b < 0.0) | (c < 0.0)) & (share > 0.0) & (share < 1.0)) ? share : Number{};
}

/// Integral of dt / radius over the increment (t from 0 to 1), with a radius linear in t; infinite where the radius is
/// not positive.
template <class In>
[[gnu::always_inline]] inline void over_radius(const typename In::Number& from, const typename In::Number& to,
                                               typename In::Number& integral) {
  using Number = typename In::Number;
  Number low = from, high = from;
  min_in_place(low, to);
  max_in_place(high, to);
  const typename In::Mask positive = low > 0.0, far = high - low >= material::logarithmic_from * low;
  integral = 2.0 / (from + to);
  const typename In::Mask both = positive & far;
  if (any(both)) {
    Number logarithm = both ? high / low : Number{} + 1.0;
    apply([](double x) { return std::log(x); }, logarithm);
    integral = far ? logarithm / (high - low) : integral;
  }
  integral = positive ? integral : Number{} + std::numeric_limits<double>::infinity();
}

/// integrate() of the header, for one particle or four.
template <class In>
[[gnu::always_inline]] inline void integrate(typename In::Number* stress, const typename In::Number* strain,
                                             const Cones<In>& cone, const Moduli<In>& elasticity,
                                             typename In::Number& plastic) {
  using Number = typename In::Number;
  using std::numbers::sqrt2;
  const Number one = Number{} + 1.0;
  // The deviator at the start, its elastic increment, and their products.
  Number s[6], ds[6];
  const Number i1_before = stress[0] + stress[1] + stress[2], volumetric = strain[0] + strain[1] + strain[2];
  for (int d = 0; d < 6; ++d) {
    s[d] = d < 3 ? stress[d] - i1_before / 3.0 : stress[d];
    ds[d] = 2.0 * elasticity.shear * (d < 3 ? strain[d] - volumetric / 3.0 : strain[d]);
  }
  const auto product = [](const Number* a, const Number* b, Number& sum) __attribute__((always_inline)) {
    sum = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + 2.0 * (a[3] * b[3] + a[4] * b[4] + a[5] * b[5]);
  };
  Number ss, sd, dd;
  product(s, s, ss);
  product(s, ds, sd);
  product(ds, ds, dd);
  const Number trial = ss + 2.0 * sd + dd, i1_trial = i1_before + 3.0 * elasticity.bulk * volumetric;
  Number i1 = i1_trial, old_part = one, new_part = one;
  plastic = Number{};
  // Outside unless clearly inside the cone, and so below its apex: a test without root and division.
  const Number room = cone.k - cone.alpha * i1_trial;
  const typename In::Mask outside =
      (room < 0.0) | (trial > 2.0 * room * room) | (i1_trial > 3.0 * cone.tensile_strength);
  if (any(outside)) {
    Number j_trial = 0.5 * trial;
    max_in_place(j_trial, Number{});
    sqrt_in_place(j_trial);
    Number j = j_trial;
    return_invariants<In>(i1, j, cone, elasticity, plastic);
    const typename In::Mask yields = plastic > 0.0;
    old_part = new_part = yields ? (j_trial > 0.0 ? j / j_trial : Number{}) : one;
    const Number along_trial = ss + sd;  // s . (s + ds)
    Number limit;
    cone.tension_limit(limit);
    const typename In::Mask turns =
        yields &
        (ss * trial - along_trial * along_trial > material::little_angle * material::little_angle * ss * trial) &
        (i1 < limit) & (j > 0.0);
    if (any(turns)) {
      // Only the plastic part of the increment turns the deviator. `first`, `last`: radius of the cone at the start and
      // at the elastic end.
      const Number first = sqrt2 * (cone.k - cone.alpha * i1_before), last = sqrt2 * room;
      Number elastic, integral;
      elastic_share<In>(ss, sd, dd, first, last - first, elastic);
      Number norm = ss + elastic * (2.0 * sd + elastic * dd), length = dd;
      sqrt_in_place(norm);
      sqrt_in_place(length);
      Number cosine = (sd + elastic * dd) / (norm * length);
      max_in_place(cosine, -one);
      min_in_place(cosine, one);
      Number sine = 1.0 - cosine * cosine;
      sqrt_in_place(sine);
      // Krieg & Krieg (1977): the angle psi between the deviator and its increment follows d psi / dt = -(|ds| /
      // radius) sin psi, so that tan(psi / 2) decays exponentially.
      const Number start = first + elastic * (last - first), end = sqrt2 * j;
      over_radius<In>(start, end, integral);
      Number left = turns ? -(1.0 - elastic) * length * integral : Number{};
      apply([](double x) { return std::exp(x); }, left);
      Number half = 1.0 + cosine;
      max_in_place(half, Number{} + 1e-12);
      left *= sine / half;
      const Number whole = 1.0 / (1.0 + left * left);
      const Number along = (1.0 - left * left) * whole, across = 2.0 * left * whole;
      // Unit vectors: ds / length, and across it ((s + elastic ds) / norm - cosine ds / length) / sine.
      const Number tilt = sine > 1e-9 ? end * across / (sine * norm) : Number{};
      old_part = turns ? tilt : old_part;
      new_part = turns ? tilt * elastic + (end * along - tilt * norm * cosine) / length : new_part;
    }
  }
  for (int d = 0; d < 6; ++d) {
    stress[d] = old_part * s[d] + new_part * ds[d];
    if (d < 3) stress[d] += i1 / 3.0;
  }
}

}  // namespace

double return_map(Tensor& stress, const Cone& cone, const Elasticity& elasticity) {
  double i1 = trace(stress), j = root_j2(stress), plastic = 0.0;
  const double mean = i1 / 3.0, before = j;
  return_invariants<InOnes>(i1, j, {cone.alpha, cone.alpha_psi, cone.k, cone.tensile_strength},
                            {elasticity.bulk, elasticity.shear}, plastic);
  if (plastic <= 0.0) return 0.0;
  for (int d = 0; d < 3; ++d) stress[d] -= mean;
  stress *= before > 0.0 ? j / before : 0.0;
  for (int d = 0; d < 3; ++d) stress[d] += i1 / 3.0;
  return plastic;
}

double integrate(Tensor& stress, const Tensor& strain, const Cone& cone, const Elasticity& elasticity) {
  double plastic = 0.0;
  integrate<InOnes>(stress.data(), strain.data(), {cone.alpha, cone.alpha_psi, cone.k, cone.tensile_strength},
                    {elasticity.bulk, elasticity.shear}, plastic);
  return plastic;
}

void DruckerPrager::advance(std::span<Four> many) const {
  const double most = soil_.maximum_void_ratio.value_or(std::numeric_limits<double>::infinity());
  const double tensile_strength = cone({}).tensile_strength;
  run_lanes([&]() __attribute__((always_inline)) {
    for (Four& four : many) {
      const LaneMask dilates = four.void_ratio < most;
      const auto choose = [&](double yes, double no, Lanes& chosen) __attribute__((always_inline)) {
        chosen = dilates ? Lanes{} + yes : Lanes{} + no;
      };
      Cones<InFours> cones;
      Lanes cohesion;
      choose(dilating_.alpha, spent_.alpha, cones.alpha);
      choose(dilating_.alpha_psi, spent_.alpha_psi, cones.alpha_psi);
      choose(dilating_.k, spent_.k, cones.k);
      cohesion_at<InFours>(soil_, four.saturation, cohesion);
      cones.k *= cohesion;
      cones.tensile_strength = tensile_strength;
      Moduli<InFours> moduli;
      elasticity_.over(four.stress, four.strain, moduli);
      integrate<InFours>(four.stress, four.strain, cones, moduli, four.plastic);
    }
  });
}

}  // namespace poretwin::solid
