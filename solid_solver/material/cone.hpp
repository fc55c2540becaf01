// The Drucker-Prager cone: its fit to Coulomb's constants, its apex and tension cut-off.
#pragma once

#include "common/case/materials.hpp"
#include "common/core/lanes.hpp"
#include "solid_solver/material/stress.hpp"

#include <limits>

namespace poretwin::solid {

/// Yield f = alpha I1 + sqrt(J2) - k (Eq. (31)); potential with alpha_psi (Eq. (30)).
struct Cone {
  double alpha = 0.0;                                                 ///< friction
  double alpha_psi = 0.0;                                             ///< dilatancy
  double k = 0.0;                                                     ///< Pa
  double tensile_strength = std::numeric_limits<double>::infinity();  ///< Pa, largest mean effective stress

  /// Largest I1 [Pa] the soil bears: the apex, or what the tension cut-off leaves.
  [[nodiscard]] double tension_limit() const {
    return alpha > 0.0 ? std::min(3.0 * tensile_strength, k / alpha) : 3.0 * tensile_strength;
  }
};

/// Cone constants; cohesion in Pa, angles in degrees.
Cone fit_cone(double cohesion, double friction_angle, double dilation_angle, Soil::Cone fit = Soil::Cone::paper);

/// Yield function f [Pa] of Eq. (31).
inline double yield_function(const Tensor& stress, const Cone& cone) {
  return cone.alpha * trace(stress) + root_j2(stress) - cone.k;
}

/// Cohesion [Pa] of one particle or of four at a degree of saturation, Eq. (36) as corrected:
/// c(s_r0) is the soil's `cohesion`, c(1) the saturated one.
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

/// The soil with its strength divided by a factor: c / F, tan(phi) / F, tensile strength / F, and what its material
/// declares as a strength, all of it before and after softening; dilation at most the reduced friction.
Soil weakened(Soil soil, double factor, const std::vector<MaterialKey>& own = {});

}  // namespace poretwin::solid
