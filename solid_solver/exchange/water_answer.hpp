// Impedance with which the water resists a departure of the soil from the predicted motion, in a long window that is
// repeated until fluid and solid agree.
#pragma once

#include <cmath>
#include <numbers>

namespace poretwin::solid {

/// Properties of a particle's water in a window. Any consistent system of units may be used.
struct WaterInWindow {
  double drag = 0.0;      ///< C, N s/m4
  double inertia = 0.0;   ///< a = n rho_w / Dt, N s/m4
  double pores = 0.0;     ///< n
  double interval = 0.0;  ///< Dt, s
};

/// Impedances that resist the soil in a pass through a window, in place of the water's own impedance. They determine
/// how fast the passes converge, but not the result.
///
/// Shear entrains the water: its impedance is C a / (a + C). Pressure resists dilation: impedance C / n^2 at any
/// wavelength, while nothing drains within the window. Let A be the stiffness in the fluid's prediction, T the true
/// one, D the water's impedance and Z the one used in its place: a pass multiplies an error by (A - T) (Z - D) / ((A +
/// D) (T + Z)). With Z = C, the motion of soil that shears freely (T = 0, D << Z) would hardly change from pass to
/// pass. With Z = 0 for dilation, long waves (D >> A) would diverge in soil less than half as stiff as predicted.
///
/// Hence the two limits are blended. Their weight is the fraction of its pressure that the shortest wave keeps over the
/// window, exp(-alpha) with alpha = Dt M (pi / 2 dx)^2 n^2 / C (Terzaghi's decay). In undrained soil the impedance is
/// the drag. In drained soil it is the water's inertia and, against dilation, half the skeleton's modulus. With these
/// impedances, errors decrease at every wavelength if the true stiffness is at least a quarter of the predicted.
struct WaterAnswer {
  double translation = 0.0;  ///< N s/m4, against a departure of the velocity
  double dilation = 0.0;     ///< Pa, against a departure of the volumetric strain
  double pressure = 0.0;     ///< N s/m4, impedance of the pressure over the soil's height, less where it drains
};

/// The impedances for the skeleton's constrained modulus M [Pa], the particle spacing [m] and the soil's height [m].
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
