// A pressure prescribed on a face: uniform, with an optional standing wave.
#pragma once

#include "fluid_solver/boundary/water_boundary.hpp"

#include <algorithm>

namespace poretwin::fluid {

class PrescribedPressure final : public WaterBoundary {
 public:
  static bool is_meant(const WaterFace& face) { return face.pressure.has_value(); }
  PrescribedPressure(const Case& /*scene*/, const WaterFace& face) : face_(face) {}

  [[nodiscard]] double pressure(const FacePlace& place, double time, const FaceState& /*state*/) const override {
    return face_.pressure->at(time) + face_.wave(place.position.x(), time);
  }
  [[nodiscard]] TimeLimit limit(double now, const AllowedChange& allowed, const FaceState& /*state*/) const override {
    return {std::max(allowed.shortest, unchanged_for(*face_.pressure, now, allowed.pressure)),
            "a pressure that changes on a face"};
  }

 private:
  WaterFace face_;
};

}  // namespace poretwin::fluid
