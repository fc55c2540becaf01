// The soil's surface under free water that another solver computes.
#pragma once

#include "pore_solver/boundary/water_behind.hpp"

namespace poretwin::pore {

/// Free water stands on a segment as the solver of that water says: with a pressure head (SegmentState::head), and as
/// much of it as the soil may take (SegmentState::pond). Where the segment is dry, it is a seepage face, and takes what
/// is left on it at the pressure of the air.
class FreeWater final : public WaterBehind {
 public:
  void begin(const StepTimes& times) override { note_interval(times.interval); }
  [[nodiscard]] Inflow inflow(const FlowModel& flow, const Segment& segment, const SegmentState& state) const override {
    const Inflow in = state.head > 0.0   ? flow.below_level(segment, 0.5 * (segment.low + segment.high) + state.head)
                      : state.pond > 0.0 ? flow.at_head(segment, 0.0)
                                         : flow.below_level(segment, -HUGE_VAL);
    if (const double most = std::max(0.0, state.pond) / interval(); in.value > most) return {most, 0.0};
    return in;
  }
  void accept(const Segment& segment, double flow, SegmentState& state, Account& account) const override {
    WaterBehind::accept(segment, flow, state, account);
    state.pond -= interval() * flow;
  }
  [[nodiscard]] double next_corner(double) const override { return HUGE_VAL; }
};

}  // namespace poretwin::pore
