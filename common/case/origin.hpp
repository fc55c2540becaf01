// Scenes far from the origin of their coordinates, such as those of a survey (UTM).
#pragma once

#include "common/case/case.hpp"

namespace poretwin {

/// Moves a scene that lies farther from the origin than it is wide, and than 1e3 particle spacings, to it, along the
/// axes across gravity, and keeps the way in general.origin. By a power of two times a whole number, so that moving back
/// loses nothing. Elevations stay: heads count from zero; so does everything where a central force, a strain, a swirl or
/// a wave is about the origin.
void move_to_origin(Case& scene);

}  // namespace poretwin
