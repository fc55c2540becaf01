// What the skeleton does to the water that flows through it: permeability and the linear seepage force.
#pragma once

#include "common/case/case.hpp"

#include <algorithm>

namespace poretwin::fluid {

/// Kozeny-Carman, Eq. (19): conductivity [m/s] at void fraction n, from its value at void fraction n0. Infinite in free
/// water.
inline double kozeny_carman(double conductivity, double n0, double n) {
  const auto shape = [](double porosity) {
    return porosity * porosity * porosity / ((1.0 - porosity) * (1.0 - porosity));
  };
  return conductivity * shape(n) / shape(n0);
}

/// Drag per volume and relative velocity, first term of Eq. (18): C = gamma_w n^2 / k [N s/m4].
inline double drag_coefficient(double specific_weight, double n, double conductivity) {
  return specific_weight * n * n / conductivity;
}

/// Specific weight [N/m3] behind the word "conductivity": that of the case's gravity, or of 9.81 m/s2 where there is
/// none.
inline double specific_weight(const Case& scene) {
  const double g = scene.general.gravity.norm();
  return scene.water.density * (g > 0.0 ? g : 9.81);
}

}  // namespace poretwin::fluid
