// Linear Darcy flow whose conductivity follows the porosity.
#pragma once

#include "common/media/seepage.hpp"

namespace poretwin::porous {

/// n^3 / (1 - n)^2, Eq. (19).
inline double kozeny_carman_shape(double n) { return n * n * n / ((1.0 - n) * (1.0 - n)); }

/// Eq. (19), from the soil's conductivity at its own porosity.
inline Seepage kozeny_carman(const Soil& soil, double n) {
  return {soil.hydraulic_conductivity * kozeny_carman_shape(n) / kozeny_carman_shape(soil.porosity), 0.0};
}

}  // namespace poretwin::porous
