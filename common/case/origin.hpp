// Moves scenes that lie far from the origin of their coordinates, such as those of a survey (UTM).
#pragma once

#include "common/case/case.hpp"

namespace poretwin {

/// Moves a scene to the origin where its distance from it exceeds its own width and 1e3 particle spacings; along axes
/// across gravity only. Keeps the displacement in general.origin; it is a whole number times a power of two, so that
/// moving back loses no digits. Elevations are unchanged, since heads are measured from zero; so are positions where a
/// central force, a strain, a swirl or a wave is centred at the origin.
void move_to_origin(Case& scene);

}  // namespace poretwin
