// No capillarity: pores are full of water below a sharp front and empty above it.
#pragma once

#include "common/media/retention_law.hpp"

namespace poretwin::porous {

inline RetentionLaw sharp() { return {"sharp", "no capillarity, a sharp front between full and empty soil"}; }

}  // namespace poretwin::porous
