// Still water behind a face that rises and falls with the tide.
#pragma once

#include "fluid_solver/boundary/water_boundary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace poretwin::fluid {

class Tide final : public WaterBoundary {
 public:
  /// Mean and amplitude of the level [m], period [s].
  Tide(double mean, double amplitude, double period)
      : mean_(mean), amplitude_(amplitude), frequency_(2.0 * std::numbers::pi / period) {}

  [[nodiscard]] std::optional<double> level(double time, const FaceState& /*state*/) const override {
    return mean_ + amplitude_ * std::sin(frequency_ * time);
  }
  [[nodiscard]] TimeLimit limit(double /*now*/, const AllowedChange& allowed,
                                const FaceState& /*state*/) const override {
    return {std::max(allowed.shortest, allowed.rise / (amplitude_ * frequency_)), "a tide"};
  }

 private:
  double mean_, amplitude_;  ///< m
  double frequency_;         ///< 1/s, angular
};

}  // namespace poretwin::fluid
