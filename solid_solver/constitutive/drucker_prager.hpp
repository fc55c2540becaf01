// Drucker-Prager elasto-plasticity with a closed-form, non-associated return map and an apex.
#pragma once

#include "solid_solver/constitutive/model.hpp"

namespace poretwin::solid {

/// Yield f = alpha I1 + sqrt(J2) - k (Eq. (31)); potential with alpha_psi (Eq. (30)).
struct Cone {
  double alpha = 0.0;      ///< friction
  double alpha_psi = 0.0;  ///< dilatancy
  double k = 0.0;          ///< Pa
};

/// Cone constants; cohesion in Pa, angles in degrees.
Cone fit_cone(double cohesion, double friction_angle, double dilation_angle, Soil::Cone fit = Soil::Cone::paper);

/// Yield function f [Pa] of Eq. (31).
double yield_function(const Tensor& stress, const Cone& cone);

/// Brings a trial stress outside the cone back, along the potential or to the apex, in one step and independent of its
/// size. Returns the equivalent deviatoric plastic strain (0 inside).
double return_map(Tensor& stress, const Cone& cone, const Elasticity& elasticity);

class DruckerPrager final : public ConstitutiveModel {
 public:
  explicit DruckerPrager(const Soil& soil)
      : ConstitutiveModel(Elasticity::of(soil)),
        cone_(fit_cone(soil.cohesion, soil.friction_angle, soil.dilation_angle, soil.cone)) {}
  double advance(Tensor& stress, const Tensor& strain) const override {
    stress += elasticity().stress_of(strain);
    return return_map(stress, cone_, elasticity());
  }

 private:
  Cone cone_;
};

}  // namespace poretwin::solid
