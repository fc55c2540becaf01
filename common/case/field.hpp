// Checks of a case whose pore water is a field on the points of the soil, and of the keys for such a field.
#pragma once

#include "common/case/case.hpp"
#include "common/case/keys.hpp"

namespace poretwin {

/// Throws CaseError at the first fault, with file, line, key, what was expected and what was found.
void check_field(const Case& scene, const Places& places);

/// Sets fluid.representation = "auto" to "field" or "particles", and Case::representation_chosen to the reason.
void choose_representation(Case& scene, const Places& places);

}  // namespace poretwin
