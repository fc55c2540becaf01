// Isotropic linear elasticity.
#pragma once

#include "solid_solver/constitutive/model.hpp"

namespace poretwin::solid {

class LinearElastic final : public ConstitutiveModel {
 public:
  explicit LinearElastic(const Soil& soil) : ConstitutiveModel(Elasticity::of(soil)) {}
  double advance(Tensor& stress, const Tensor& strain, const Condition& /*condition*/ = {}) const override {
    stress += elasticity().stress_of(strain);
    return 0.0;
  }
};

}  // namespace poretwin::solid
