// A reservoir whose level follows from its inflow and from the volume that passes the face.
#pragma once

#include "common/case/basin.hpp"
#include "fluid_solver/boundary/water_boundary.hpp"

namespace poretwin::fluid {

class Basin final : public WaterBoundary {
 public:
  static bool is_meant(const WaterFace& face) { return face.basin_area.has_value(); }
  Basin(const Case& scene, const WaterFace& face);

  [[nodiscard]] FaceState initial() const override { return {basin_volume(area_, first_level_), first_level_, 0.0}; }
  [[nodiscard]] std::optional<double> level(double /*time*/, const FaceState& state) const override {
    return state.level;
  }
  void advance(double time, double interval, const Passage& passed, FaceState& state) const override {
    state.supplied += inflow_.integral(time, time + interval);
    state.level = basin_level(area_, state.supplied - passed.before - passed.during);
  }
  /// Throws DivergedError where the basin's level is above the upper end of a face over which the basin cannot flow.
  void check(double time, const FaceState& state) const override;
  [[nodiscard]] TimeLimit limit(double now, const AllowedChange& allowed, const FaceState& state) const override;

 private:
  Series area_;                      ///< m2 (2D: m), against elevation [m]
  Series inflow_;                    ///< m3/s (2D: m2/s), against time [s]
  double first_level_ = 0.0;         ///< m
  double crest_ = HUGE_VAL;          ///< m, elevation of the face's upper end if the basin cannot flow over it
  std::string why_not_over_, face_;  ///< reason why it cannot flow over; the face, for messages
};

}  // namespace poretwin::fluid
