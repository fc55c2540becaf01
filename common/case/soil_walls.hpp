// Checks of moving soil and its walls: that soil lies in front of its walls and on them, and that none of it is cut off
// by them from all that would hold it up.
#pragma once

#include "common/case/case.hpp"
#include "common/case/keys.hpp"

namespace poretwin {

/// Throws CaseError with the reason where a wall or load of moving soil would act wrongly.
void check_soil_walls(const Case& scene, const Places& places);

}  // namespace poretwin
