// Checks of a case that involve several keys: geometry, physics, and consistency of its parts.
#pragma once

#include "common/case/case.hpp"
#include "common/case/keys.hpp"

namespace poretwin {

/// Throws CaseError at the first fault, with file, line, key, what was expected and what was found.
void check_case(const Case& scene, const Places& places);

}  // namespace poretwin
