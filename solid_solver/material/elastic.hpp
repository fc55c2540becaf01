// Isotropic linear elasticity.
#pragma once

#include "solid_solver/material/model.hpp"

namespace poretwin::solid {

class LinearElastic final : public ConstitutiveModel {
 public:
  using ConstitutiveModel::advance;
  explicit LinearElastic(const Soil& soil) : elasticity_(Elasticity::of(soil)) {}
  double advance(Tensor& stress, const Tensor& strain, const Condition& /*condition*/,
                 std::span<double> /*state*/) const override {
    elasticity_.add_stress(strain.data(), stress.data());
    return 0.0;
  }
  void advance(std::span<Four> many) const override {
    run_lanes([&]() __attribute__((always_inline)) {
      for (Four& four : many) {
        elasticity_.add_stress(four.strain, four.stress);
        four.plastic = Lanes{};
      }
    });
  }
  [[nodiscard]] Elasticity moduli(std::span<const double> /*state*/) const override { return elasticity_; }

 private:
  Elasticity elasticity_;
};

}  // namespace poretwin::solid
