// The shortest characteristic time of a case.
#pragma once

#include "common/case/case.hpp"

#include <string>
#include <utility>

namespace poretwin {

/// The shortest time [s] that a case prescribes or that follows from it for one particle spacing, and its name. It is
/// the least of: free fall through the spacing, an elastic wave or viscous diffusion across it, motion through it at a
/// given speed or at the speed of a jet from a given pressure or, for water as a field, of its front, and the
/// prescribed windows and frames. Windows may be shorter, but not by orders of magnitude.
std::pair<double, std::string> shortest_time(const Case& scene);

}  // namespace poretwin
