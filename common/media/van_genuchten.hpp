// van Genuchten (1980) with Mualem's (1976) permeability, and with the air entry head of Vogel et al. (2001) and
// Ippisch et al. (2006).
#pragma once

#include "common/media/retention_law.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin::porous {

/// With x = (alpha |psi|)^n, m = 1 - 1/n, S = (1 + x)^-m and S_c = S at the air entry head h_e:
/// S_e = S / S_c and k_r = S_e^l [(1 - (1 - S^(1/m))^m) / (1 - (1 - S_c^(1/m))^m)]^2 for psi < -h_e; 1 above.
class VanGenuchten final : public RetentionCurve {
 public:
  /// Length below psi = 0 over which a straight line replaces k_r if n < 2 and there is no entry head: otherwise the
  /// slope of k_r at psi = 0 is infinite, and Newton's method would fail. The infiltration changes by less than the
  /// error of the discretisation. Unit: m. Test: Retention.NearlyFullSoilConductsAlongAStraightLine.
  static constexpr double straight = 1e-3;

  VanGenuchten(double alpha, double n, double entry_head, double connectivity)
      : alpha_(alpha), n_(n), m_(1.0 - 1.0 / n), entry_(entry_head), l_(connectivity) {
    full_ = raw(-entry_);
    // d2S/dpsi2 = 0 at x = m.
    steepest_ = std::min(-entry_, -std::pow(m_, 1.0 / n_) / alpha_);
    straight_ = n_ < 2.0 && entry_ == 0.0;
    if (straight_) at_straight_ = curved(-straight).value;
  }
  [[nodiscard]] Rate saturation(double psi) const override {
    if (psi >= -entry_) return {1.0, 0.0};
    const Raw r = raw(psi);
    return {r.saturation / full_.saturation, r.slope / full_.saturation};
  }
  [[nodiscard]] Rate permeability(double psi) const override {
    if (psi >= -entry_) return {1.0, 0.0};
    if (!straight_ || psi <= -straight) return curved(psi);
    const double slope = (1.0 - at_straight_) / straight;
    return {1.0 + slope * psi, slope};
  }
  [[nodiscard]] double head(double saturation) const override {
    return -std::pow(std::expm1(-std::log(saturation * full_.saturation) / m_), 1.0 / n_) / alpha_;
  }
  [[nodiscard]] double steepest() const override { return steepest_; }

 private:
  struct Raw {
    double saturation = 1.0, slope = 0.0;  ///< S, dS/dpsi
    double way = 1.0, way_slope = 0.0;     ///< w = 1 - (1 - S^(1/m))^m and its derivative
  };
  [[nodiscard]] Raw raw(double psi) const {
    if (psi >= 0.0) return {};
    Raw r;
    const double x = std::pow(-alpha_ * psi, n_), dx = n_ * x / psi;
    r.saturation = std::exp(-m_ * std::log1p(x));
    r.slope = -m_ * r.saturation / (1.0 + x) * dx;
    const double logarithm = -m_ * std::log1p(1.0 / x);  // logarithm of (1 - S^(1/m))^m
    r.way = -std::expm1(logarithm);
    r.way_slope = -std::exp(logarithm) * m_ / (x * (1.0 + x)) * dx;
    return r;
  }
  [[nodiscard]] Rate curved(double psi) const {
    const Raw r = raw(psi);
    const double s = r.saturation / full_.saturation, way = r.way / full_.way;
    const double value = std::pow(s, l_) * way * way;
    return {value, value * (l_ * r.slope / r.saturation + 2.0 * r.way_slope / r.way)};
  }

  double alpha_, n_, m_, entry_, l_;
  Raw full_;  ///< at the air entry head
  double steepest_ = 0.0;
  bool straight_ = false;
  double at_straight_ = 1.0;
};

inline RetentionLaw van_genuchten() {
  return {"van_genuchten",
          "van Genuchten (1980) and Mualem (1976)",
          {{"alpha", "1/m", "Inverse of the head over which the soil drains (`van_genuchten`, `gardner`).", 0.0, true},
           {"n", "", "Exponent, above 1 (`van_genuchten`).", 0.0, true, 1.0},
           {"entry_head", "m", "Suction h_e at which air enters (`brooks_corey`, `van_genuchten`)."},
           {"pore_connectivity", "", "Mualem's exponent l (`van_genuchten`).", 0.5}},
          false,
          [](const RetentionParameters& p) -> std::unique_ptr<RetentionCurve> {
            return std::make_unique<VanGenuchten>(p.numbers[0], p.numbers[1], p.numbers[2], p.numbers[3]);
          }};
}

}  // namespace poretwin::porous
