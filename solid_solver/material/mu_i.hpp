// The mu(I) rheology of dense granular flow, dry or in a viscous liquid, with a dilatancy that follows the packing.
#pragma once

#include "solid_solver/material/model.hpp"

namespace poretwin::solid {

/// Grains without cohesion whose friction depends on the rate of shear g [1/s] at the pressure p [Pa] (Jop, Forterre &
/// Pouliquen 2006; Boyer, Guazzelli & Pouliquen 2011) and whose dilation depends on the packing (Pailha & Pouliquen
/// 2009):
///   I = g d sqrt(rho_s / p),  J = eta g / p       inertial and viscous number
///   mu = mu_s + (mu_2 - mu_s) m / (1 + m),  m = I / I_0 + J / J_0
///   phi_eq = phi_c / (1 + sqrt(J) + b I)          solid fraction at which shear goes on at constant volume
///   tan psi = K_psi (phi - phi_eq)                volumetric strain over shear strain, negative in loose soil
///   sqrt(J2) = (mu + tan psi) p                   while the soil flows
/// with the grains' diameter d and density rho_s, the solid fraction phi, and the viscosity eta of the water times the
/// degree of saturation. The elastic part is that of PressureElasticity. State variable: the rate of plastic shear.
class MuI final : public ConstitutiveModel {
 public:
  using ConstitutiveModel::advance;
  explicit MuI(const Soil& soil);
  [[nodiscard]] std::size_t state_size() const override { return 1; }
  [[nodiscard]] std::vector<StateVariable> state_variables() const override {
    return {{"plastic_shear_rate", "1/s", "rate of plastic shear strain"}};
  }
  double advance(Tensor& stress, const Tensor& strain, const Condition& condition,
                 std::span<double> state) const override;
  [[nodiscard]] Elasticity moduli(const Tensor& stress, std::span<const double> /*state*/) const override {
    return elasticity_.at(-trace(stress) / 3.0);
  }
  /// By the friction mu_s of very slow shear; what the packing adds to it, K_psi (phi - phi_c), is not divided.
  [[nodiscard]] double local_factor(const Tensor& stress, const Condition& condition,
                                    std::span<const double> state) const override;

  static Material row();  ///< row of the table of materials

 private:
  struct Flow;

  PressureElasticity elasticity_;
  double static_friction_, gained_friction_;  ///< mu_s, mu_2 - mu_s
  double inertial_rate_;                      ///< sqrt(Pa) s: I over g / sqrt(p)
  double inertial_half_, viscous_half_;       ///< I_0, J_0
  double dilatancy_, critical_, loosening_;   ///< K_psi, phi_c, b
};

}  // namespace poretwin::solid
