// The shortest time in which a case moves.
#pragma once

#include "common/case/case.hpp"

#include <string>
#include <utility>

namespace poretwin {

/// The shortest time that a case names or implies for one particle spacing [s], and what it is the time of: of a fall
/// through the spacing, of a wave of the skeleton or diffusion by viscosity across it, of motion at a given speed or at
/// that of a jet from a given pressure; also the windows and frames that the case prescribes. Windows may well be
/// shorter, but not by orders of magnitude.
std::pair<double, std::string> shortest_time(const Case& scene);

}  // namespace poretwin
