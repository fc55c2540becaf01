// No capillarity: pores are full below a sharp front and hold no water above it.
#pragma once

#include "common/media/retention_law.hpp"

namespace poretwin::porous {

inline RetentionLaw sharp() { return {"sharp", "no capillarity, a sharp front between full and empty soil"}; }

}  // namespace poretwin::porous
