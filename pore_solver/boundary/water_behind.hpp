// Faces with water or air behind them: reservoirs, prescribed pressures, outlets.
#pragma once

#include "pore_solver/boundary/pore_boundary.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace poretwin::pore {

/// Common base of the faces of this file: it sums their inflow and outflow.
class WaterBehind : public PoreBoundary {
 public:
  void accept(const Segment&, double flow, SegmentState&, Account& account) const override {
    (flow > 0.0 ? account.in : account.out) += interval_ * std::abs(flow);
  }

 protected:
  void note_interval(double interval) { interval_ = interval; }
  [[nodiscard]] double interval() const { return interval_; }  ///< s

 private:
  double interval_ = 0.0;  ///< s
};

/// Still water up to a head, which may change in time. The face above this head is a seepage face.
class Reservoir final : public WaterBehind {
 public:
  explicit Reservoir(Series head) : head_(std::move(head)) {}
  void begin(const StepTimes& times) override {
    level_ = head_.at(times.now);
    note_interval(times.interval);
  }
  [[nodiscard]] Inflow inflow(const FlowModel& flow, const Segment& segment, const SegmentState&) const override {
    return flow.below_level(segment, level_);
  }
  [[nodiscard]] std::optional<double> level() const override { return level_; }
  [[nodiscard]] double next_corner(double time) const override { return next_knot(head_, time); }

 private:
  Series head_;  ///< m
  double level_ = 0.0;
};

/// A prescribed pressure, uniform along the face.
class PrescribedPressure final : public WaterBehind {
 public:
  PrescribedPressure(Series pressure, double specific_weight)
      : pressure_(std::move(pressure)), specific_weight_(specific_weight) {}
  void begin(const StepTimes& times) override {
    head_ = pressure_.at(times.now) / specific_weight_;
    note_interval(times.interval);
  }
  [[nodiscard]] Inflow inflow(const FlowModel& flow, const Segment& segment, const SegmentState&) const override {
    return flow.at_head(segment, head_);
  }
  [[nodiscard]] double next_corner(double time) const override { return next_knot(pressure_, time); }

 private:
  Series pressure_;  ///< Pa
  double specific_weight_, head_ = 0.0;
};

/// Air behind the face: water can only leave, as at a seepage face or a drain.
class Outlet final : public WaterBehind {
 public:
  void begin(const StepTimes& times) override { note_interval(times.interval); }
  [[nodiscard]] Inflow inflow(const FlowModel& flow, const Segment& segment, const SegmentState&) const override {
    return flow.below_level(segment, -HUGE_VAL);
  }
  [[nodiscard]] double next_corner(double) const override { return HUGE_VAL; }
};

}  // namespace poretwin::pore
