// Modified Cam-Clay (Roscoe & Burland 1968), integrated implicitly.
#pragma once

#include "solid_solver/material/model.hpp"

namespace poretwin::solid {

/// Yield surface f = q^2 - M^2 p (pc - p), associated flow. Hardening: d pc / pc = v / (lambda - kappa) times the
/// plastic compression. Elasticity: bulk modulus v p / kappa, constant Poisson's ratio. p, q, pc: mean pressure,
/// deviator and preconsolidation pressure [Pa], compression positive; v = 1 + e. Below the soil's `least_pressure` the
/// moduli do not decrease further; pc is at least `least_pressure`. State variables: pc [Pa], v.
class ModifiedCamClay final : public ConstitutiveModel {
 public:
  using ConstitutiveModel::advance;
  explicit ModifiedCamClay(const Soil& soil);
  [[nodiscard]] std::size_t state_size() const override { return 2; }
  [[nodiscard]] std::vector<StateVariable> state_variables() const override {
    return {{"preconsolidation_pressure", "Pa", "size of the yield surface along the mean effective pressure"},
            {"specific_volume", "1", "volume over that of the grains"}};
  }
  void initial(const Tensor& stress, std::span<double> state) const override;
  double advance(Tensor& stress, const Tensor& strain, const Condition& condition,
                 std::span<double> state) const override;
  void advance(std::span<Four> many) const override;
  [[nodiscard]] Elasticity moduli(const Tensor& stress, std::span<const double> state) const override;
  /// By the strength at the critical state, q = M p, which is what `poretwin safety` divides; below 1 where heavily
  /// overconsolidated clay carries more than that.
  [[nodiscard]] double local_factor(const Tensor& stress, const Condition& condition,
                                    std::span<const double> state) const override;

  static Material row();  ///< row of the table of materials

 private:
  double lambda_, kappa_, slope_;    ///< lambda, kappa, M
  double shear_ratio_;               ///< G / K
  double specific_volume_;           ///< initial v
  double ratio_, preconsolidation_;  ///< overconsolidation ratio; pc [Pa], 0: computed from the ratio
  double least_;                     ///< Pa, least pressure
};

}  // namespace poretwin::solid
