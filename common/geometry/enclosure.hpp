// Checks whether the case's water is enclosed. Walls and water faces must close around it; otherwise it runs out.
#pragma once

#include "common/case/case.hpp"

namespace poretwin {

/// A gap through which water leaves.
struct Leak {
  Point3 at;                                         ///< m, at the gap
  std::vector<std::pair<std::string, Point3>> ends;  ///< free ends of the boundary beside the gap: name, place [m]
};

/// A place where water could run out, at or below its highest initial level. Empty if walls, faces and periodic sides
/// enclose the water, if there is no gravity, or if no wall is intended to enclose water.
std::optional<Leak> find_leak(const Case& scene);

}  // namespace poretwin
