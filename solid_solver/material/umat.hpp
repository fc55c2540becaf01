// A user's own model in a shared library, in the convention of Abaqus' UMAT (docs/extending/umat.md).
#pragma once

#include "solid_solver/material/model.hpp"

namespace poretwin::solid {

/// State: the library's own variables, then the total strain that the library gets. The moduli are those that the case
/// gives for the soil. The model must never be stiffer than these.
class Umat final : public ConstitutiveModel {
 public:
  using ConstitutiveModel::advance;
  explicit Umat(const Soil& soil);
  [[nodiscard]] std::size_t state_size() const override { return own_ + 6; }
  [[nodiscard]] std::vector<StateVariable> state_variables() const override;
  double advance(Tensor& stress, const Tensor& strain, const Condition& condition,
                 std::span<double> state) const override;
  [[nodiscard]] Elasticity moduli(const Tensor& /*stress*/, std::span<const double> /*state*/) const override {
    return elasticity_;
  }

  /// Reports a library that is missing or lacks the function, and a library whose response to zero strain is not finite
  /// or is stiffer than the elastic moduli that the case gives for the soil.
  static void judge(const Soil& soil, const Material::Complain& complain);

 private:
  struct Answer;
  [[nodiscard]] Answer ask(const Tensor& stress, const Tensor& strain, std::span<double> state) const;
  Elasticity elasticity_;
  std::vector<double> properties_;
  std::string library_;
  std::size_t own_;  ///< number of the library's own state variables
  void* function_;
};

}  // namespace poretwin::solid
