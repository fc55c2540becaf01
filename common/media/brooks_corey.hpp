// Retention after Brooks & Corey (1964): a power law for heads below the air entry head.
#pragma once

#include "common/media/retention_law.hpp"

#include <cmath>

namespace poretwin::porous {

/// S_e = (h_e / |psi|)^lambda for psi < -h_e, else 1, with the air entry head h_e and the pore-size index lambda; k_r =
/// S_e^(3 + 2 / lambda) (Burdine 1953).
class BrooksCorey final : public RetentionCurve {
 public:
  BrooksCorey(double entry_head, double lambda) : entry_(entry_head), lambda_(lambda) {}
  [[nodiscard]] Rate saturation(double psi) const override { return power(psi, lambda_); }
  [[nodiscard]] Rate permeability(double psi) const override { return power(psi, 3.0 * lambda_ + 2.0); }
  [[nodiscard]] double head(double saturation) const override { return -entry_ * std::pow(saturation, -1.0 / lambda_); }
  [[nodiscard]] double steepest() const override { return -entry_; }

 private:
  /// (h_e / |psi|)^exponent.
  [[nodiscard]] Rate power(double psi, double exponent) const {
    if (psi > -entry_) return {1.0, 0.0};
    const double value = std::pow(-entry_ / psi, exponent);
    return {value, -exponent * value / psi};
  }
  double entry_;   ///< h_e, m
  double lambda_;  ///< pore-size index
};

inline RetentionLaw brooks_corey() {
  return {"brooks_corey",
          "S_e = (h_e / |psi|)^lambda, k_r = S_e^(3 + 2 / lambda)",
          {{"entry_head", "m", "Suction h_e at which air enters (`brooks_corey`, `van_genuchten`).", 0.0, true},
           {"pore_size_index", "", "lambda (`brooks_corey`).", 0.0, true}},
          false,
          [](const RetentionParameters& p) -> std::unique_ptr<RetentionCurve> {
            return std::make_unique<BrooksCorey>(p.numbers[0], p.numbers[1]);
          }};
}

}  // namespace poretwin::porous
