// Drucker-Prager elasto-plasticity with a closed-form, non-associated return map, an apex and a tension cut-off.
#pragma once

#include "solid_solver/material/cone.hpp"
#include "solid_solver/material/model.hpp"

namespace poretwin::solid {

/// Adds the elastic stress of a strain increment and returns the stress to the cone. The result is the equivalent
/// deviatoric plastic strain. The invariants are exact where the deviator keeps its direction. Where it turns, its
/// direction follows in closed form from the direction of the strain (exact at psi = 0).
double integrate(Tensor& stress, const Tensor& strain, const Cone& cone, const Elasticity& elasticity);

/// Returns a trial stress outside the cone to the cone, in one step of any size: along the potential, to the tension
/// limit, or to the edge where both meet. The result is the equivalent deviatoric plastic strain (0 inside the cone).
double return_map(Tensor& stress, const Cone& cone, const Elasticity& elasticity);

/// Common base of the two integrations of the model: the cone in the soil's present condition.
class DruckerPragerSoil : public ConstitutiveModel {
 public:
  explicit DruckerPragerSoil(const Soil& soil);
  /// The cohesion decreases with saturation, Eq. (36); dilation ends at the soil's largest void ratio.
  [[nodiscard]] Cone cone(const Condition& condition) const;
  [[nodiscard]] bool can_dilate(const Condition& condition) const {
    return !soil_.maximum_void_ratio || condition.void_ratio < *soil_.maximum_void_ratio;
  }
  [[nodiscard]] Elasticity moduli(const Tensor& stress, std::span<const double> /*state*/) const override {
    return elasticity_.at(-trace(stress) / 3.0);
  }
  [[nodiscard]] double local_factor(const Tensor& stress, const Condition& condition,
                                    std::span<const double> /*state*/) const override;

 protected:
  PressureElasticity elasticity_;
  Soil soil_;
  Cone dilating_, spent_;  ///< cones of unit cohesion: with dilation, and without
};

class DruckerPrager final : public DruckerPragerSoil {
 public:
  using ConstitutiveModel::advance;
  using DruckerPragerSoil::DruckerPragerSoil;
  double advance(Tensor& stress, const Tensor& strain, const Condition& condition,
                 std::span<double> /*state*/) const override {
    Moduli<InOnes> moduli;
    elasticity_.over(stress.data(), strain.data(), moduli);
    return integrate(stress, strain, cone(condition), {moduli.bulk, moduli.shear});
  }
  void advance(std::span<Four> many) const override;
};

}  // namespace poretwin::solid
