// Hydraulic conductivity of a deforming soil, and the drag it stands for.
#pragma once

#include "common/case/case.hpp"

namespace poretwin::solid {

/// Kozeny-Carman, Eq. (19), relative to the soil's own conductivity at its own porosity [m/s]; porosity: current n_w.
inline double conductivity(const Soil& soil, double porosity) {
  auto shape = [](double n) { return n * n * n / ((1.0 - n) * (1.0 - n)); };
  return soil.hydraulic_conductivity * shape(porosity) / shape(soil.porosity);
}

/// Weight that hydraulic conductivity refers to [N/m3]: standard gravity when the case has none.
inline double water_weight(const Case& scene) {
  const double g = scene.general.gravity.norm();
  return scene.water.density * (g > 0.0 ? g : 9.81);
}

/// Drag coefficient C = gamma_w n^2 / k of Eq. (18) [N s/m4].
inline double drag_coefficient(double water_weight, double porosity, double conductivity) {
  return water_weight * porosity * porosity / conductivity;
}

}  // namespace poretwin::solid
