// Is the case's water enclosed? Walls and water faces must close around it, or it runs out.
#pragma once

#include "common/case/case.hpp"

namespace poretwin {

/// A way out for the water.
struct Leak {
  Point3 at;                                         ///< m, on the way out, at the gap
  std::vector<std::pair<std::string, Point3>> ends;  ///< the boundary's free ends beside the gap: which, where [m]
};

/// Where water could run out, at or below the highest level it starts from; nothing where walls, faces and periodic
/// sides enclose it, where there is no gravity, or where no wall is meant to enclose water.
std::optional<Leak> find_leak(const Case& scene);

}  // namespace poretwin
