// Still water whose level follows from the balance of a basin.
#pragma once

#include "common/case/basin.hpp"
#include "pore_solver/boundary/water_behind.hpp"
#include "pore_solver/numerics/basins.hpp"

namespace poretwin::pore {

/// The basin stores water up to its level; `Stepper` finds the level at which its balance closes. Above the level the
/// face is a seepage face, whose water runs down into the basin.
///
/// A level part of the face, such as the bed of a pit, is wet in part while the level is within a film below it. Hence
/// the inflow grows continuously with the level, and a dry basin passes on to the soil what is poured and rains into
/// it, as far as the soil takes it.
class Basin final : public WaterBehind {
 public:
  Basin(const WaterFace& face, double spacing)
      : area_(*face.basin_area),
        poured_(*face.discharge),
        rain_(face.basin_rain.value_or(Series{{{0.0, 0.0}}})),
        bottom_(area_.knots.front().first),
        spill_level_(face.spill_level.value_or(HUGE_VAL)),
        first_level_(basin_first_level(face)),
        film_(basins::film * spacing) {}

  void begin(const StepTimes& times) override {
    note_interval(times.interval);
    // Means over the step are used at every instant of the step, so that the volumes are exact.
    pouring_ = poured_.integral(times.start, times.start + times.interval) / times.interval;
    raining_ = rain_.integral(times.start, times.start + times.interval) / times.interval;
  }
  [[nodiscard]] double next_corner(double time) const override {
    return std::min(next_knot(poured_, time), next_knot(rain_, time));
  }
  [[nodiscard]] Inflow inflow(const FlowModel& flow, const Segment& segment, const SegmentState&) const override {
    return inflow_at(flow, segment, level_);
  }
  [[nodiscard]] std::optional<double> level() const override { return std::max(level_, bottom_); }

  [[nodiscard]] bool finds_level() const override { return true; }
  [[nodiscard]] LevelRange levels(double, double) const override {
    return {bottom_ - film_, spill_level_, first_level_};
  }
  [[nodiscard]] double first_volume() const override { return basin_volume(area_, first_level_); }
  void set_level(double elevation) override { level_ = elevation; }
  [[nodiscard]] Inflow inflow_at(const FlowModel& flow, const Segment& segment, double level) const override {
    if (segment.high > segment.low || level > segment.low) return flow.below_level(segment, level);
    const Inflow dry = flow.below_level(segment, -HUGE_VAL);
    if (level <= segment.low - film_) return dry;
    const Inflow wet = flow.at_head(segment, 0.0);
    const double share = 1.0 + (level - segment.low) / film_;
    return {(1.0 - share) * dry.value + share * wet.value, (1.0 - share) * dry.slope + share * wet.slope};
  }
  void begin_stage(const BasinStage& stage) override {
    stage_ = stage;
    // A stage may take no more of the water that was there at the step's start, and add no more to it up to the spill
    // level, than its share of the step. Otherwise the whole step would take more than there was.
    least_ = (1.0 - stage.share) * stage.at_start;
    most_ = std::isfinite(spill_level_)
                ? stage.at_start + stage.share * (basin_volume(area_, spill_level_) - stage.at_start)
                : HUGE_VAL;
  }
  [[nodiscard]] double wants(double level) const override {
    return (stored_at(level) - stage_.base) / stage_.interval - pouring_ - raining_ * area_.at(level);
  }
  [[nodiscard]] BasinRates rates(double into_soil, bool at_end) const override {
    const double rain = raining_ * area_.at(level_);
    BasinRates r;
    r.in = std::max(0.0, pouring_) + std::max(0.0, rain);
    r.out = std::max(0.0, -pouring_) + std::max(0.0, -rain);
    const double surplus = r.in - r.out - into_soil - (stored_at(level_) - stage_.base) / stage_.interval;
    // Elsewhere the surplus is the rounding of the search for the level, and the water remains in the basin. Where by
    // such rounding the soil took more than there was, the stored volume falls below zero by it.
    if (at_end && surplus > 0.0) r.spilled = surplus;
    if (at_end && surplus < 0.0) r.out = std::max(0.0, r.out + surplus);
    r.gain = r.in - r.out - r.spilled - into_soil;
    return r;
  }
  [[nodiscard]] double depth() const override { return std::max(0.0, level_ - bottom_); }
  [[nodiscard]] double area() const override { return area_.at(level_); }

 private:
  [[nodiscard]] double stored_at(double level) const {
    return std::clamp(level > bottom_ ? basin_volume(area_, level) : 0.0, least_, most_);
  }

  Series area_, poured_, rain_;  ///< m2 (2D: m) against elevation [m]; m3/s (2D: m2/s) and m/s against time [s]
  double bottom_, spill_level_, first_level_, film_;  ///< m
  double pouring_ = 0.0, raining_ = 0.0;              ///< m3/s (2D: m2/s); m/s: means over the step
  double level_ = 0.0;                                ///< m; below the bottom: a part of a level bed is wet
  BasinStage stage_;
  double least_ = 0.0, most_ = HUGE_VAL;  ///< m3 (2D: m2), bounds of the stored volume at the stage's end
};

}  // namespace poretwin::pore
