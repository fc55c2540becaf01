// Refuses cases that would run and give wrong numbers; each criterion stands beside the measured errors.
#pragma once

#include "common/case/case.hpp"
#include "common/case/keys.hpp"

namespace poretwin {

/// Throws CaseError at the first fault, with file, line, key, what was expected and what was found.
void check_supported(const Case& scene, const Places& places);
/// The part of it that also applies to water as a field: loads that the soil would not bear as the case says.
void check_loads(const Case& scene, const Places& places);

}  // namespace poretwin
