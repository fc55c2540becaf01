// Isotropic linear elasticity.
#pragma once

#include "solid_solver/material/model.hpp"

namespace poretwin::solid {

class LinearElastic final : public ConstitutiveModel {
 public:
  using ConstitutiveModel::advance;
  explicit LinearElastic(const Soil& soil) : elasticity_(soil) {}
  double advance(Tensor& stress, const Tensor& strain, const Condition& /*condition*/,
                 std::span<double> /*state*/) const override {
    Moduli<InOnes> moduli;
    elasticity_.over(stress.data(), strain.data(), moduli);
    add_stress<InOnes>(moduli, strain.data(), stress.data());
    return 0.0;
  }
  void advance(std::span<Four> many) const override {
    run_lanes([&]() __attribute__((always_inline)) {
      for (Four& four : many) {
        Moduli<InFours> moduli;
        elasticity_.over(four.stress, four.strain, moduli);
        add_stress<InFours>(moduli, four.strain, four.stress);
        four.plastic = Lanes{};
      }
    });
  }
  [[nodiscard]] Elasticity moduli(const Tensor& stress, std::span<const double> /*state*/) const override {
    return elasticity_.at(-trace(stress) / 3.0);
  }

 private:
  PressureElasticity elasticity_;
};

}  // namespace poretwin::solid
