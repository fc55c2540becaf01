// No capillarity: water fills the pores below a sharp front, and above it there is none.
#pragma once

#include "common/media/retention_law.hpp"

namespace poretwin::porous {

inline RetentionLaw sharp() { return {"sharp", "no capillarity, a sharp front between full and empty soil"}; }

}  // namespace poretwin::porous
