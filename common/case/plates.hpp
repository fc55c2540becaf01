// Checks of the rigid plates of a case.
#pragma once

#include "common/case/case.hpp"
#include "common/case/keys.hpp"

namespace poretwin {

/// Throws CaseError at the first fault, with file, line, key, what was expected and what was found.
void check_plates(const Case& scene, const Places& places);

}  // namespace poretwin
