// Isotropic linear elasticity.
#pragma once

#include "solid_solver/material/model.hpp"

namespace poretwin::solid {

class LinearElastic final : public ConstitutiveModel {
 public:
  explicit LinearElastic(const Soil& soil) : ConstitutiveModel(Elasticity::of(soil)) {}
  double advance(Tensor& stress, const Tensor& strain, const Condition& /*condition*/ = {}) const override {
    elasticity().add_stress(strain.data(), stress.data());
    return 0.0;
  }
  void advance(std::span<Four> many) const override {
    run_lanes([&]() __attribute__((always_inline)) {
      for (Four& four : many) {
        elasticity().add_stress(four.strain, four.stress);
        four.plastic = Lanes{};
      }
    });
  }
};

}  // namespace poretwin::solid
