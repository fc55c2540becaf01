// Moves scenes that lie far from the origin of their coordinates, such as scenes in survey coordinates (UTM).
#pragma once

#include "common/case/case.hpp"

namespace poretwin {

/// Moves a scene to the origin where its distance from the origin exceeds its own width and 1e3 particle spacings, only
/// along axes across gravity. Stores the displacement in general.origin. It is a whole number times a power of two, so
/// that moving back loses no digits. Elevations do not change, since heads are measured from zero. Positions do not
/// change if a central force, a strain, a swirl or a wave is centred at the origin.
void move_to_origin(Case& scene);

}  // namespace poretwin
