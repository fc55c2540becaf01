// A discharge that is let in through a face as particles of water, or drawn off.
#pragma once

#include "fluid_solver/boundary/water_boundary.hpp"

namespace poretwin::fluid {

class PrescribedDischarge final : public WaterBoundary {
 public:
  static bool is_meant(const WaterFace& face) { return face.discharge && !face.basin_area; }
  PrescribedDischarge(const Case& /*scene*/, const WaterFace& face) : discharge_(*face.discharge) {}

  [[nodiscard]] std::optional<double> let_in(double from, double to) const override {
    return discharge_.integral(from, to);
  }

 private:
  Series discharge_;  ///< m3/s (2D: m2/s), against time
};

}  // namespace poretwin::fluid
