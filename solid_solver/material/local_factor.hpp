// The local factor of safety: the number by which a soil's strength can be divided until its stress reaches the
// strength. Equations: docs/theory/materials.md#local-factor-of-safety.
#pragma once

#include "common/case/materials.hpp"
#include "solid_solver/material/stress.hpp"

namespace poretwin::solid {

/// A yield surface in terms of cohesion c [Pa] and friction angle phi:
///   tau (a sqrt(1 + b tan^2 phi) + d tan phi) = c + p tan phi
/// with a shear stress tau and a mean pressure p [Pa]. The right side is proportional to the strength.
struct ShearSurface {
  double a = 1.0, b = 0.0, d = 0.0;
};

/// Coulomb's surface: tau is half the difference of the largest and the smallest principal stress, p their mean.
inline constexpr ShearSurface coulomb{1.0, 1.0, 0.0};

/// A cone fitted to Coulomb's constants, as fit_cone() computes it: tau = sqrt(J2), p = -I1 / 3.
/// dilation_angle: radians.
ShearSurface shear_surface(Soil::Cone fit, double dilation_angle);

/// The number F for which the state (tau, p) lies on the surface of the strength c / F, tan(phi) / F. Infinite without
/// shear stress. The apex belongs to the surfaces of every F: soil there yields, and its factor is 1. Zero where the
/// mean stress or a principal stress lies beyond the apex. NaN where there is neither stress nor cohesion.
double factor_to_yield(const ShearSurface& surface, double cohesion, double tan_phi, double tau, double p);

/// The smaller of a factor in shear and the one in tension, T / F = tension. Only tension [Pa] limits the factor, and
/// only where the tensile strength T [Pa] is positive: a strength of zero stays zero for every F.
double limit_by_tension(double factor, double tensile_strength, double tension);

/// The factor of soil with a Drucker-Prager cone; cohesion and tensile strength in Pa, angles in radians. As in
/// weakened(), the dilation angle is reduced where the friction angle would fall below it.
double local_factor_of_cone(Soil::Cone fit, double cohesion, double friction_angle, double dilation_angle,
                            double tensile_strength, const Tensor& stress);

}  // namespace poretwin::solid
