// Still water of a prescribed level behind a face: a pond, a reservoir, tailwater.
#pragma once

#include "fluid_solver/boundary/water_boundary.hpp"

#include <algorithm>

namespace poretwin::fluid {

class PrescribedHead final : public WaterBoundary {
 public:
  static bool is_meant(const WaterFace& face) { return face.head && !face.discharge; }
  PrescribedHead(const Case& /*scene*/, const WaterFace& face) : head_(*face.head) {}

  [[nodiscard]] std::optional<double> level(double time, const FaceState& /*state*/) const override {
    return head_.at(time);
  }
  [[nodiscard]] TimeLimit limit(double now, const AllowedChange& allowed, const FaceState& /*state*/) const override {
    return {std::max(allowed.shortest, unchanged_for(head_, now, allowed.rise)), "a level that changes behind a face"};
  }

 private:
  Series head_;  ///< m, against time [s]
};

}  // namespace poretwin::fluid
