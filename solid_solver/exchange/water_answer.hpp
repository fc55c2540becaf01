// What the water puts against soil that departs from the motion which the fluid predicted, in a long window that is
// repeated until both agree.
#pragma once

#include <cmath>
#include <numbers>

namespace poretwin::solid {

/// One particle's water in a window; any units that fit together.
struct WaterInWindow {
  double drag = 0.0;      ///< C, N s/m4
  double inertia = 0.0;   ///< a = n rho_w / Dt, N s/m4
  double pores = 0.0;     ///< n
  double interval = 0.0;  ///< Dt, s
};

/// The answer of pass after pass, in place of the water: what makes the passes converge, not what they converge to.
///
/// Shear takes the water along, C a / (a + C). Dilation is held by the pressure: by C / n^2, whatever its wavelength,
/// as far as nothing drains within the window. With the stiffness A that the fluid predicts, the true one T, the
/// water's impedance D and Z in its place a pass leaves (A - T) (Z - D) / ((A + D) (T + Z)) of an error. Z = C holds
/// soil that shears freely (T = 0, D << Z): the passes hardly move. Nothing against dilation lets long waves diverge (D
/// >> A) once the soil is half as stiff as predicted.
///
/// So both, by what a wave of the shortest length keeps of its pressure over the window, exp(-alpha) with alpha =
/// Dt M (pi / 2 dx)^2 n^2 / C (Terzaghi's decay). Where nothing drains: the drag. Where all does: the water's inertia,
/// and half the skeleton's own modulus against dilation, with which errors shrink at every wavelength down to a quarter
/// of the stiffness predicted.
struct WaterAnswer {
  double translation = 0.0;  ///< N s/m4, against a departure of the velocity
  double dilation = 0.0;     ///< Pa, against a departure of the strain of volume
  double pressure = 0.0;     ///< N s/m4, of the pressure over the soil's height, less where it drains there
};

/// modulus: M of the skeleton [Pa]; spacing, height [m].
inline WaterAnswer answer_of(const WaterInWindow& water, double modulus, double spacing, double height) {
  if (water.drag <= 0.0) return {};
  const double shortest = 0.5 * std::numbers::pi / spacing;
  const double alpha = water.interval * modulus * shortest * shortest * water.pores * water.pores / water.drag;
  const double drains = 1.0 - std::exp(-alpha);
  const double along = water.drag * water.inertia / (water.inertia + water.drag);
  return {drains * along + (1.0 - drains) * water.drag, 0.5 * drains * modulus,
          1.0 / (1.0 / water.drag + height * height / (water.interval * modulus))};
}

}  // namespace poretwin::solid
