// The ground's surface under rain or evaporation.
#pragma once

#include "pore_solver/boundary/pore_boundary.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin::pore {

/// Water that stands on the soil infiltrates as fast as the soil can take it. The remaining rain ponds up to a given
/// depth, and the water above this depth runs off. Evaporation takes ponded water first, then the soil's water, down to
/// a given suction at the surface. Where the soil is saturated and its water under pressure, water leaves the soil:
/// through the water face along the segment if there is one, otherwise onto the surface.
class Surface final : public PoreBoundary {
 public:
  Surface(const Rain& rain, bool has_face) : rain_(rain), has_face_(has_face) {}
  void begin(const StepTimes& times) override {
    interval_ = times.interval;
    // The mean rain over the step is used at every instant of the step, so that the volume of rain is exact.
    rate_ = rain_.rate->integral(times.start, times.start + interval_) / interval_;
  }
  [[nodiscard]] Inflow inflow(const FlowModel& flow, const Segment& segment, const SegmentState& state) const override {
    const double there = available(segment, state);
    const double depth = segment.level_area > 0.0 ? state.pond / segment.level_area : 0.0;
    // The bounds are evaluated only where they can apply.
    if (const Inflow most = flow.at_head(segment, depth); most.value < there) return most;
    if (there < 0.0)
      if (const Inflow least = flow.at_head(segment, -rain_.limit_suction); least.value > there)
        return least.value < 0.0 ? least : Inflow{};
    return {there, 0.0};
  }
  void accept(const Segment& segment, double flow, SegmentState& state, Account& account) const override {
    const double soaked = interval_ * flow;
    double on_top = state.pond + interval_ * rate_ * segment.level_area;
    if (soaked >= 0.0) {
      account.infiltration += soaked;
      on_top -= soaked;
    } else {
      // Evaporation takes its part first. Other water that leaves the soil seeps out.
      const double vapour = std::clamp(-on_top, 0.0, -soaked), seeps = -soaked - vapour;
      account.evaporation += vapour;
      account.out += seeps;
      if (!has_face_) on_top += seeps;
    }
    const double most = rain_.ponding_depth * segment.level_area;
    state.pond = std::clamp(on_top, 0.0, most);
    account.runoff += std::max(0.0, on_top - most);
  }
  [[nodiscard]] double next_corner(double time) const override { return next_knot(*rain_.rate, time); }

 private:
  /// Rate [m3/s, 2D: m2/s] at which water is available for infiltration in the step. A negative value is the rate of
  /// evaporation from the soil.
  [[nodiscard]] double available(const Segment& segment, const SegmentState& state) const {
    return state.pond / interval_ + rate_ * segment.level_area;
  }

  Rain rain_;
  bool has_face_;
  double interval_ = 1.0, rate_ = 0.0;  ///< s, length of the step; m/s, mean rain
};

}  // namespace poretwin::pore
