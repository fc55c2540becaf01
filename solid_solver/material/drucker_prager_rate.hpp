// The Drucker-Prager soil integrated as in Bui & Nguyen (2017): explicit rates, then scaling-back of the stress.
#pragma once

#include "solid_solver/material/drucker_prager.hpp"

namespace poretwin::solid {

/// Eqs. (86), (87) as corrected, with one explicit Euler step per increment. The treatment of tension cracking and the
/// scaling-back of the stress (Bui et al. 2008) follow. The error is of first order in the increment.
class DruckerPragerRate final : public DruckerPragerSoil {
 public:
  using ConstitutiveModel::advance;
  using DruckerPragerSoil::DruckerPragerSoil;
  double advance(Tensor& stress, const Tensor& strain, const Condition& condition,
                 std::span<double> state) const override;
};

}  // namespace poretwin::solid
