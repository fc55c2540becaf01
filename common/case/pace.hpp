// The shortest time in which a case moves.
#pragma once

#include "common/case/case.hpp"

#include <string>
#include <utility>

namespace poretwin {

/// The least of the times that a case names or implies for one particle spacing [s], and what it is of: a fall through
/// it, a wave of the soil's skeleton, diffusion by viscosity, the way at a given speed or at that of a jet from a given
/// pressure; and the windows and frames that it asks for. Windows may well be shorter, but not by orders of magnitude.
std::pair<double, std::string> shortest_time(const Case& scene);

}  // namespace poretwin
