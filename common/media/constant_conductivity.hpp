// Linear Darcy flow whose conductivity does not change.
#pragma once

#include "common/media/seepage.hpp"

namespace poretwin::porous {

inline Seepage constant_conductivity(const Soil& soil) { return {soil.hydraulic_conductivity, 0.0}; }

}  // namespace poretwin::porous
