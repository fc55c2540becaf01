// A face with air behind it: water that crosses the face has left the domain.
#pragma once

#include "fluid_solver/boundary/water_boundary.hpp"

namespace poretwin::fluid {

class Outlet final : public WaterBoundary {
 public:
  static bool is_meant(const WaterFace& face) { return face.outlet; }
  Outlet(const Case& /*scene*/, const WaterFace& /*face*/) {}
};

}  // namespace poretwin::fluid
