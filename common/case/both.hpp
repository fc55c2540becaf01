// Checks of a case whose water is particles where it is free and a field in the soil: what this does not do, and which
// keys belong to which part.
#pragma once

#include "common/case/case.hpp"
#include "common/case/keys.hpp"

namespace poretwin {

/// Throws CaseError at the first thing in the case that particles and a field together cannot do.
void check_both(const Case& scene, const Places& places);

/// The places of all keys but those that belong to the other part.
Places places_of_ground(const Places& places);
Places places_of_free_water(const Places& places);

}  // namespace poretwin
