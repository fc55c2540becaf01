// Retention after Gardner (1958): exponential curves, for which Richards' equation is linear in k.
#pragma once

#include "common/media/retention_law.hpp"

#include <cmath>

namespace poretwin::porous {

/// S_e = k_r = exp(alpha psi).
class Gardner final : public RetentionCurve {
 public:
  explicit Gardner(double alpha) : alpha_(alpha) {}
  [[nodiscard]] Rate saturation(double psi) const override {
    const double e = std::exp(alpha_ * psi);
    return {e, alpha_ * e};
  }
  [[nodiscard]] Rate permeability(double psi) const override { return saturation(psi); }
  [[nodiscard]] double head(double saturation) const override { return std::log(saturation) / alpha_; }
  [[nodiscard]] double steepest() const override { return 0.0; }

 private:
  double alpha_;  ///< 1/m
};

inline RetentionLaw gardner() {
  return {"gardner",
          "S_e = k_r = exp(alpha psi)",
          {{"alpha", "1/m", "Inverse of the head over which the soil drains (`van_genuchten`, `gardner`).", 0.0, true}},
          false,
          [](const RetentionParameters& p) -> std::unique_ptr<RetentionCurve> {
            return std::make_unique<Gardner>(p.numbers[0]);
          }};
}

}  // namespace poretwin::porous
