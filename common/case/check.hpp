// Checks of a case that no single key can make: geometry, physics, and whether the parts fit together.
#pragma once

#include "common/case/case.hpp"
#include "common/case/keys.hpp"

namespace poretwin {

/// Throws CaseError naming file, line, key, what was expected and what was found.
void check_case(const Case& scene, const Places& places);

}  // namespace poretwin
