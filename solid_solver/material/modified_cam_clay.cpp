#include "solid_solver/material/modified_cam_clay.hpp"

#include "solid_solver/material/local_factor.hpp"
#include "solid_solver/numerics/material.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <type_traits>

namespace poretwin::solid {
namespace {

// The functions below treat one particle (In = InOnes) or four at a time (InFours).

struct Constants {
  double by_swelling, by_hardening;  ///< 1 / kappa, 1 / (lambda - kappa)
  double slope, shear_ratio, least;
};

/// State of one particle or four; p and pc are positive in compression.
template <class In>
struct Clay {
  using Number = typename In::Number;
  Number p, pc, v;  ///< mean pressure [Pa]; preconsolidation pressure [Pa]; specific volume [1]
  Number s[6];      ///< Pa, deviator
  Number plastic;   ///< accumulated equivalent deviatoric plastic strain of the increment
};

/// a : b.
template <class In>
[[gnu::always_inline]] inline void product(const typename In::Number* a, const typename In::Number* b,
                                           typename In::Number& sum) {
  sum = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + 2.0 * (a[3] * b[3] + a[4] * b[4] + a[5] * b[5]);
}

/// One implicit step for a volumetric compression and a deviatoric strain e. The unknowns are the multiplier m and the
/// plastic compression d in
///   d = m M^2 (2 p - pc), q^2 = M^2 p (pc - p), s = (s0 + 2 G e) / (1 + 6 G m),
/// with p(d) and pc(d) from the trapezoidal rule for their laws, and G at the mean p. Newton's iteration begins at the
/// elastic trial, from where the second equation decreases convexly in m. Returns false if it did not converge.
template <class In>
[[gnu::always_inline]] inline bool step(const Constants& k, const typename In::Number& compression,
                                        const typename In::Number* e, Clay<In>& clay) {
  using Number = typename In::Number;
  using Mask = typename In::Mask;
  const Number one = Number{} + 1.0, zero{};
  const Number v = clay.v * (1.0 - 0.5 * compression);  // at the middle of the step
  const Number a = v * k.by_swelling, b = v * k.by_hardening, m2 = zero + k.slope * k.slope;
  const Mask high = clay.p >= k.least;
  Number ss, se, ee;
  product<In>(clay.s, clay.s, ss);
  product<In>(clay.s, e, se);
  product<In>(e, e, ee);
  Number multiplier{}, plastic{}, p, shear, w = one;
  Number pc = clay.pc, growth = one;  // growth: 1 / (1 - z); pc grows by the factor (1 + z) / (1 - z)
  Mask yields{};
  for (int round = 0;; ++round) {
    const Number y = a * (compression - plastic), left = 1.0 / (1.0 - 0.5 * y);
    p = high ? clay.p * (1.0 + 0.5 * y) * left : clay.p + k.least * y;
    const Number mean = 0.5 * (clay.p + p);
    const Mask above = mean > k.least;
    shear = k.shear_ratio * a * (above ? mean : zero + k.least);
    if (round > 0) {
      growth = 1.0 / (1.0 - 0.5 * b * plastic);
      pc = clay.pc * (2.0 * growth - 1.0);
      max_in_place(pc, zero + k.least);
      w = 1.0 / (1.0 + 6.0 * shear * multiplier);
    }
    const Number q2 = 1.5 * (ss + 4.0 * shear * (se + shear * ee)) * w * w;
    const Number f = q2 - m2 * p * (pc - p);
    if (round == 0) {
      yields = f > cam_clay::reached * clay.pc * clay.pc;
      if (!any(yields)) break;
    }
    const Number flow = m2 * (2.0 * p - pc), r = plastic - multiplier * flow;
    // Ends by the residuals of the yield surface, relative to pc^2, and of the flow rule.
    const Number most = cam_clay::reached * clay.pc * clay.pc;
    const Mask open = yields & ((f * f > most * most) | (r * r > cam_clay::reached * cam_clay::reached));
    if (!any(open)) break;
    if (round == cam_clay::rounds) return false;
    const Number dp = -a * (high ? clay.p * left * left : zero + k.least);
    const Number dpc = pc > k.least ? clay.pc * b * growth * growth : zero;
    const Number dshear = above ? 0.5 * k.shear_ratio * a * dp : zero;
    const Number r_m = -flow, r_d = 1.0 - multiplier * m2 * (2.0 * dp - dpc);
    const Number f_m = -12.0 * shear * w * q2;
    const Number f_d = (6.0 * (se + 2.0 * shear * ee) * w * w - 12.0 * multiplier * w * q2) * dshear -
                       m2 * (dp * (pc - 2.0 * p) + p * dpc);
    const Number determinant = r_m * f_d - r_d * f_m;
    const Number of_m = (r * f_d - f * r_d) / determinant, of_d = (f * r_m - r * f_m) / determinant;
    multiplier -= open ? of_m : zero;
    plastic -= open ? of_d : zero;
  }
  clay.p = p;
  clay.pc = pc;
  clay.v *= 1.0 - compression;
  for (int c = 0; c < 6; ++c) clay.s[c] = (clay.s[c] + 2.0 * shear * e[c]) * w;
  if (!any(yields)) return true;
  // The equivalent plastic strain is 2 m q, since the plastic deviatoric strain is 3 m s.
  product<In>(clay.s, clay.s, ss);
  Number q = 1.5 * ss;
  sqrt_in_place(q);
  Number sheared = 2.0 * multiplier * q;
  max_in_place(sheared, zero + std::numeric_limits<double>::min());
  clay.plastic += yields ? sheared : zero;
  return true;
}

/// Divides the increment into `finer` times as many steps as its size requires. Returns false if a step did not
/// converge.
template <class In>
[[gnu::always_inline]] inline bool follow(const Constants& k, const typename In::Number* strain,
                                          typename In::Number* stress, double finer, Clay<In>& clay) {
  using Number = typename In::Number;
  const Number volumetric = strain[0] + strain[1] + strain[2], mean = (stress[0] + stress[1] + stress[2]) / 3.0;
  Number e[6], ee;
  for (int c = 0; c < 6; ++c) {
    clay.s[c] = c < 3 ? stress[c] - mean : stress[c];
    e[c] = c < 3 ? strain[c] - volumetric / 3.0 : strain[c];
  }
  clay.p = -mean;
  clay.plastic = Number{};
  product<In>(e, e, ee);
  sqrt_in_place(ee);
  Number pressure = clay.p;
  max_in_place(pressure, Number{} + k.least);
  Number size = volumetric < 0.0 ? -volumetric : volumetric;
  size += 2.0 * k.shear_ratio * ee * (clay.pc < pressure ? pressure / clay.pc : Number{} + 1.0);
  size *= clay.v * (k.by_swelling / cam_clay::longest_step);
  double most = finer;
  if constexpr (std::is_same_v<In, InOnes>)
    most = std::max(most, finer * size);
  else
    for (std::size_t l = 0; l < n_lanes; ++l) most = std::max(most, finer * size[l]);
  const double steps = std::ceil(std::min(most, cam_clay::most_steps)), share = 1.0 / steps;
  for (Number& part : e) part *= share;
  const Number compression = -volumetric * share;
  for (int n = 0; n < static_cast<int>(steps); ++n)
    if (!step<In>(k, compression, e, clay)) return false;
  for (int c = 0; c < 6; ++c) stress[c] = c < 3 ? clay.s[c] - clay.p : clay.s[c];
  return true;
}

/// Follows the increment, with more and more steps until all of them converge.
template <class In>
[[gnu::always_inline]] inline void follow(const Constants& k, const typename In::Number* strain,
                                          typename In::Number* stress, Clay<In>& clay) {
  for (double finer = 1.0;; finer *= 4.0) {
    Clay<In> trial = clay;
    if (follow<In>(k, strain, stress, finer, trial)) {
      clay = trial;
      return;
    }
    if (finer >= cam_clay::finest)
      throw MaterialFailure{"modified_cam_clay: no stress was found for a strain increment, in steps however fine"};
  }
}

}  // namespace

Material ModifiedCamClay::row() {
  return {"modified_cam_clay",
          Material::Strength::own,
          {{"compression_slope",
            0.1,
            {"", "lambda: specific volume over ln p on the line of normal compression (modified_cam_clay)."},
            positive()},
           {"swelling_slope",
            0.02,
            {"", "kappa: specific volume over ln p in unloading; less than `compression_slope`."},
            positive()},
           {"critical_state_slope", 1.0, {"", "M: q / p at the critical state."}, positive(), true},
           {"overconsolidation_ratio",
            1.0,
            {"", "Preconsolidation pressure over the one whose yield surface passes through the initial stress."},
            Range{.min = 1.0}},
           {"preconsolidation_pressure",
            0.0,
            {"Pa",
             "Preconsolidation pressure, the same everywhere, in place of the ratio; where the initial stress needs a "
             "larger one, that one counts; 0: from the ratio."},
            not_negative()}},
          [](const Soil& soil, const Material::Complain& complain) {
            // In triaxial compression q / p is 3 where the lateral stress vanishes.
            if (constexpr double tensile = 3.0; soil.own("critical_state_slope") >= tensile)
              complain("critical_state_slope",
                       fmt::format("expected less than {:g}, beyond which the soil would bear tension; M is a ratio of "
                                   "stresses, 6 sin(phi) / (3 - sin(phi)), found {}",
                                   tensile, soil.own("critical_state_slope")));
            if (soil.own("swelling_slope") >= soil.own("compression_slope"))
              complain("swelling_slope", fmt::format("expected less than the compression slope of {}, found {}",
                                                     soil.own("compression_slope"), soil.own("swelling_slope")));
          },
          true};
}

ModifiedCamClay::ModifiedCamClay(const Soil& soil)
    : lambda_(soil.own("compression_slope")),
      kappa_(soil.own("swelling_slope")),
      slope_(soil.own("critical_state_slope")),
      shear_ratio_(1.5 * (1.0 - 2.0 * soil.poissons_ratio) / (1.0 + soil.poissons_ratio)),
      specific_volume_(1.0 / (1.0 - soil.porosity)),
      ratio_(soil.own("overconsolidation_ratio")),
      preconsolidation_(soil.own("preconsolidation_pressure")),
      least_(soil.least_pressure) {}

void ModifiedCamClay::initial(const Tensor& stress, std::span<double> state) const {
  const double p = std::max(-trace(stress) / 3.0, least_), q = std::sqrt(3.0) * root_j2(stress);
  const double through = p + q * q / (slope_ * slope_ * p);
  state[0] = preconsolidation_ > 0.0 ? std::max(preconsolidation_, through) : ratio_ * through;
  state[1] = specific_volume_;
}

Elasticity ModifiedCamClay::moduli(const Tensor& stress, std::span<const double> state) const {
  const double bulk = state[1] * std::max(-trace(stress) / 3.0, least_) / kappa_;
  return {bulk, shear_ratio_ * bulk};
}

double ModifiedCamClay::local_factor(const Tensor& stress, const Condition& /*condition*/,
                                     std::span<const double> /*state*/) const {
  return factor_to_yield({}, 0.0, slope_, std::sqrt(3.0) * root_j2(stress), -trace(stress) / 3.0);
}

double ModifiedCamClay::advance(Tensor& stress, const Tensor& strain, const Condition& condition,
                                std::span<double> state) const {
  Clay<InOnes> clay{};
  clay.pc = state[0];
  clay.v = 1.0 + condition.void_ratio;
  follow<InOnes>({1.0 / kappa_, 1.0 / (lambda_ - kappa_), slope_, shear_ratio_, least_}, strain.data(), stress.data(),
                 clay);
  state[0] = clay.pc;
  state[1] = clay.v;
  return clay.plastic;
}

void ModifiedCamClay::advance(std::span<Four> many) const {
  const Constants constants{1.0 / kappa_, 1.0 / (lambda_ - kappa_), slope_, shear_ratio_, least_};
  std::size_t place = 0;
  const auto all = [&]() __attribute__((always_inline)) {
    for (; place < many.size(); ++place) {
      Four& four = many[place];
      Clay<InFours> clay{};
      clay.pc = four.state[0].v;
      clay.v = 1.0 + four.void_ratio;
      follow<InFours>(constants, four.strain, four.stress, clay);
      four.state[0].v = clay.pc;
      four.state[1].v = clay.v;
      four.plastic = clay.plastic;
    }
  };
  try {
    run_lanes(all);
  } catch (MaterialFailure& failure) {
    failure.place = place * n_lanes;
    throw;
  }
}

}  // namespace poretwin::solid
