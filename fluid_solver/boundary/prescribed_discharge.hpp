// A prescribed discharge that enters through a face as water particles, or is drawn off.
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
  Series discharge_;  ///< m3/s (2D: m2/s), against time [s]
};

}  // namespace poretwin::fluid
