// The Drucker-Prager cone: its fit to Coulomb's constants, its apex and its tension cut-off.
#pragma once

#include "common/case/materials.hpp"
#include "common/core/lanes.hpp"
#include "solid_solver/material/stress.hpp"

#include <limits>

namespace poretwin::solid {

/// Yield surface f = alpha I1 + sqrt(J2) - k (Eq. (31)); the plastic potential has alpha_psi in place of alpha (Eq.
/// (30)).
struct Cone {
  double alpha = 0.0;                                                 ///< 1, friction
  double alpha_psi = 0.0;                                             ///< 1, dilatancy
  double k = 0.0;                                                     ///< Pa, cohesion
  double tensile_strength = std::numeric_limits<double>::infinity();  ///< Pa, largest mean effective stress

  /// Largest I1 [Pa] that the soil bears: at the apex, or at the tension cut-off where that is lower.
  [[nodiscard]] double tension_limit() const {
    return alpha > 0.0 ? std::min(3.0 * tensile_strength, k / alpha) : 3.0 * tensile_strength;
  }
};

/// Constants of the cone, fitted to Coulomb's constants by the method `fit`; cohesion in Pa, angles in degrees.
Cone fit_cone(double cohesion, double friction_angle, double dilation_angle, Soil::Cone fit = Soil::Cone::paper);

/// Yield function f [Pa] of Eq. (31).
inline double yield_function(const Tensor& stress, const Cone& cone) {
  return cone.alpha * trace(stress) + root_j2(stress) - cone.k;
}

/// Cohesion [Pa] of one particle or of four at a degree of saturation, Eq. (36) as corrected: linear between the soil's
/// `cohesion` at its initial saturation and `saturated_cohesion` at saturation 1.
template <class In>
[[gnu::always_inline]] inline void cohesion_at(const Soil& soil, const typename In::Number& saturation,
                                               typename In::Number& cohesion) {
  using Number = typename In::Number;
  cohesion = Number{} + soil.cohesion;
  if (!soil.saturated_cohesion) return;
  Number share{};
  if (soil.initial_saturation < 1.0) share = (1.0 - saturation) / (1.0 - soil.initial_saturation);
  max_in_place(share, Number{});
  min_in_place(share, Number{} + 1.0);
  cohesion = *soil.saturated_cohesion + (soil.cohesion - *soil.saturated_cohesion) * share;
}
inline double cohesion_at(const Soil& soil, double saturation) {
  double cohesion = 0.0;
  cohesion_at<InOnes>(soil, saturation, cohesion);
  return cohesion;
}

/// The soil with its strength divided by a factor F: c / F, tan(phi) / F, tensile strength / F. The keys that its
/// material declares as strengths (own) are divided as well, both before and after softening. The dilation angle is at
/// most the reduced friction angle.
Soil weakened(Soil soil, double factor, const std::vector<MaterialKey>& own = {});

}  // namespace poretwin::solid
