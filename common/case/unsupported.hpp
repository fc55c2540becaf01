// Refuses cases that would run but give wrong results. Each criterion has the measured errors beside it.
#pragma once

#include "common/case/case.hpp"
#include "common/case/keys.hpp"

namespace poretwin {

/// Throws CaseError at the first fault, with file, line, key, what was expected and what was found.
void check_supported(const Case& scene, const Places& places);
/// The part of check_supported for water as a field: loads that the soil would not bear as the case describes.
void check_loads(const Case& scene, const Places& places);

}  // namespace poretwin
