// Water behind a face whose level is not prescribed: what is poured in and what leaves through the face decide it.
#pragma once

#include "common/case/case.hpp"

namespace poretwin::fluid {

/// Volume [m^D] that a basin holds up to a level [m].
inline double basin_volume(const Series& area, double level) { return area.integral(area.knots.front().first, level); }

/// Level [m] of a volume [m^D]: area linear between the knots, constant above the last. No water: the bottom.
double basin_level(const Series& area, double volume);

}  // namespace poretwin::fluid
