// The ground's surface under rain, or giving off vapour.
#pragma once

#include "pore_solver/boundary/pore_boundary.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin::pore {

/// What falls soaks in as far as the soil takes it under what stands on it; the rest ponds up to a depth, and runs off.
/// Evaporation takes what stands there first, then the soil's water, as long as the soil is no drier at the surface
/// than a limit. Where the soil is full and its water under pressure it comes out: through the water face along the
/// segment if there is one, into runoff if not.
class Surface final : public PoreBoundary {
 public:
  Surface(const Rain& rain, bool has_face) : rain_(rain), has_face_(has_face) {}
  void begin(const StepTimes& times) override {
    interval_ = times.interval;
    // What falls is counted exactly: the mean over the step at any instant of it.
    rate_ = rain_.rate->integral(times.start, times.start + interval_) / interval_;
  }
  [[nodiscard]] Inflow inflow(const FlowModel& flow, const Segment& segment, const SegmentState& state) const override {
    const double there = available(segment, state);
    const double depth = segment.level_area > 0.0 ? state.pond / segment.level_area : 0.0;
    // Bounds are asked for only where they may hold.
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
      // Vapour first; what the soil gives beyond it seeps out.
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
  /// What could soak in during the step if the soil took all of it, per time; below zero what vapour would take.
  [[nodiscard]] double available(const Segment& segment, const SegmentState& state) const {
    return state.pond / interval_ + rate_ * segment.level_area;
  }

  Rain rain_;
  bool has_face_;
  double interval_ = 1.0, rate_ = 0.0;  ///< s, m/s
};

}  // namespace poretwin::pore
