// Linear Darcy flow with a conductivity that is independent of the porosity.
#pragma once

#include "common/media/seepage_law.hpp"

namespace poretwin::porous {

inline SeepageLaw constant_conductivity() {
  return {"constant", "the same k at any porosity", [](const Medium& m) { return Seepage{m.conductivity, 0.0}; }};
}

}  // namespace poretwin::porous
