// Volume and level of a basin whose horizontal area is given against elevation.
#pragma once

#include "common/case/case.hpp"

namespace poretwin {

/// Volume [m^D] of a basin up to a level [m]. area: surface area against elevation.
inline double basin_volume(const Series& area, double level) { return area.integral(area.knots.front().first, level); }

/// Level [m] at a volume [m^D]. The area is linear between the knots and constant above the last knot. Without water
/// the level is the bottom.
double basin_level(const Series& area, double volume);

/// Level at time zero [m] of the basin behind a face: its head, and at least the bottom.
double basin_first_level(const WaterFace& face);

}  // namespace poretwin
