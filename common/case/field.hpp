// Checks of a case whose water is a field on the soil's points, and of keys that belong to one.
#pragma once

#include "common/case/case.hpp"
#include "common/case/keys.hpp"

namespace poretwin {

/// Throws CaseError naming file, line, key, what was expected and what was found.
void check_field(const Case& scene, const Places& places);

}  // namespace poretwin
