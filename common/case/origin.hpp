// Scenes far from the origin of their coordinates, such as those of a survey (UTM).
#pragma once

#include "common/case/case.hpp"

namespace poretwin {

/// Moves a scene that lies more than 1e5 particle spacings from the origin to it, along the axes across gravity, and
/// keeps the way in general.origin. By whole metres, so that moving back loses nothing. Elevations stay: heads count
/// from zero; so does everything where a central force, a strain or a swirl is about the origin.
void move_to_origin(Case& scene);

}  // namespace poretwin
