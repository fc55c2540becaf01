// Scenes that would run and give wrong numbers: refused, each by a criterion that stands here with what was measured.
#pragma once

#include "common/case/case.hpp"
#include "common/case/keys.hpp"

namespace poretwin {

/// Throws CaseError naming file, line, key, what was expected and what was found.
void check_supported(const Case& scene, const Places& places);

}  // namespace poretwin
