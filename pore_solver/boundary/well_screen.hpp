// The screen of a well that pumps a given discharge.
#pragma once

#include "pore_solver/boundary/water_behind.hpp"

namespace poretwin::pore {

/// The well contains still water up to a level at which the screen as a whole passes the prescribed discharge
/// (`Stepper` finds this level). Above the level, water seeps out of the soil and falls down the well.
class WellScreen final : public WaterBehind {
 public:
  explicit WellScreen(Series discharge) : discharge_(std::move(discharge)) {}
  void begin(const StepTimes& times) override {
    note_interval(times.interval);
    // The mean discharge over the step is used at every instant of the step, so that the pumped volume is exact.
    inflow_ = -discharge_.integral(times.start, times.start + times.interval) / times.interval;
  }
  [[nodiscard]] Inflow inflow(const FlowModel& flow, const Segment& segment, const SegmentState&) const override {
    return flow.below_level(segment, level_);
  }
  [[nodiscard]] std::optional<double> level() const override { return level_; }
  [[nodiscard]] bool finds_level() const override { return true; }
  [[nodiscard]] LevelRange levels(double low, double high) const override { return {low, HUGE_VAL, high}; }
  [[nodiscard]] double wants(double) const override { return -inflow_; }
  void set_level(double elevation) override { level_ = elevation; }
  [[nodiscard]] double next_corner(double time) const override { return next_knot(discharge_, time); }

 private:
  Series discharge_;                   ///< m3/s (2D: m2/s), out of the soil
  double inflow_ = 0.0, level_ = 0.0;  ///< m3/s (2D: m2/s); m
};

}  // namespace poretwin::pore
