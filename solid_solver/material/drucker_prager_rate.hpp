// The same Drucker-Prager soil integrated as the paper does: explicit rates, then stress scaling-back.
#pragma once

#include "solid_solver/material/drucker_prager.hpp"

namespace poretwin::solid {

/// Eqs. (86), (87) as corrected, one explicit Euler step per increment; tension cracking treatment and stress
/// scaling-back afterwards (Bui et al. 2008). First-order accurate: its error grows with the increment.
class DruckerPragerRate final : public DruckerPragerSoil {
 public:
  using ConstitutiveModel::advance;
  using DruckerPragerSoil::DruckerPragerSoil;
  double advance(Tensor& stress, const Tensor& strain, const Condition& condition,
                 std::span<double> state) const override;
};

}  // namespace poretwin::solid
