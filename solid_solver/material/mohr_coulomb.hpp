// Mohr-Coulomb elasto-plasticity: a closed-form, non-associated return in principal stresses, with a tension cut-off.
#pragma once

#include "solid_solver/material/cone.hpp"
#include "solid_solver/material/model.hpp"

namespace poretwin::solid {

/// Yield surface f = (s1 - s3) + (s1 + s3) sin(phi) - 2 c cos(phi) = 0 with principal stresses s1 >= s2 >= s3, tension
/// positive. The potential has psi in place of phi. Where s1 = s2 or s2 = s3, two faces yield (Koiter 1953). No
/// principal stress exceeds the tensile strength or the apex, c / tan(phi). At that limit the flow is associated
/// (Rankine), so that soil without dilation can also reach its apex.
///
/// If the soil has a residual strength, c, phi and psi decrease linearly with the plastic shear strain, up to the
/// strain softening_slip / band_width. The plastic shear strain is the state variable.
class MohrCoulomb final : public ConstitutiveModel {
 public:
  using ConstitutiveModel::advance;
  explicit MohrCoulomb(const Soil& soil);
  [[nodiscard]] std::size_t state_size() const override { return softens_ ? 1 : 0; }
  [[nodiscard]] std::vector<StateVariable> state_variables() const override;
  double advance(Tensor& stress, const Tensor& strain, const Condition& condition,
                 std::span<double> state) const override;
  void advance(std::span<Four> many) const override;
  [[nodiscard]] Elasticity moduli(const Tensor& stress, std::span<const double> /*state*/) const override {
    return elasticity_.at(-trace(stress) / 3.0);
  }
  [[nodiscard]] double local_factor(const Tensor& stress, const Condition& condition,
                                    std::span<const double> state) const override;

 private:
  /// A value that falls linearly from `from` to `from + by`.
  struct Fall {
    double from, by;
  };
  /// Cohesion [Pa], and how far the strength has fallen from its first to its residual value (0 to 1).
  template <class In>
  void soften(const typename In::Number& saturation, const typename In::Number* softened, typename In::Number& cohesion,
              typename In::Number& share) const;
  template <class In>
  void follow(const typename In::Number& saturation, const typename In::Number& void_ratio,
              const typename In::Number* strain, typename In::Number* stress, typename In::Number* softened,
              typename In::Number& plastic) const;
  PressureElasticity elasticity_;
  Soil soil_;
  Fall friction_, dilation_;            ///< radians
  Fall cohesion_;                       ///< relative to the cohesion at the present saturation
  double sin_phi_, cos_phi_, sin_psi_;  ///< before any softening
  bool softens_;
  double residual_strain_;     ///< plastic shear strain at which the strength is the residual strength
  double tensile_strength_;    ///< Pa, infinite where the soil has no separate tension cut-off
  double largest_void_ratio_;  ///< void ratio at which dilation ends
};

}  // namespace poretwin::solid
