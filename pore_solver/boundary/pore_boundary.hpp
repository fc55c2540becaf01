// Inflow through a segment of the soil's border: one class for each kind of boundary, each in a file of its own.
#pragma once

#include "common/case/case.hpp"
#include "pore_solver/flow.hpp"

#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace poretwin::pore {

/// The data of a boundary for one segment. They are part of the saved state.
struct SegmentState {
  double pond = 0.0;  ///< m3 (2D: m2), water that stands on the surface of the segment
  double head = 0.0;  ///< m, pressure head of free water at its centre; zero or below: none stands there
};

/// Volumes of water since the start of the run [m3, 2D: m2].
struct Account {
  double in = 0.0, out = 0.0;  ///< inflow through water faces; outflow of liquid water, also under rain
  double infiltration = 0.0;   ///< infiltration of rain
  double evaporation = 0.0;    ///< evaporation of the soil's water
  double runoff = 0.0;         ///< water that could neither infiltrate nor pond; it never entered the soil
  /// Total gain of water in the soil.
  [[nodiscard]] double gained() const { return in + infiltration - out - evaporation; }
};

/// A step in time [s].
struct StepTimes {
  double start = 0.0, interval = 0.0;
  double now = 0.0;  ///< the instant at which flows are computed
};

/// Range of a level that follows from a balance [m], and the level at time zero.
struct LevelRange {
  double least = 0.0, most = HUGE_VAL, first = 0.0;
};

/// A stage of a step, to a basin.
struct BasinStage {
  double at_start = 0.0;  ///< m3 (2D: m2), volume of its water at the step's start
  double base = 0.0;      ///< m3 (2D: m2), volume at the stage's end without what comes and goes in the stage
  double interval = 1.0;  ///< s, length of the stage
  double share = 1.0;     ///< place of the stage's end in the step
};

/// Rates of a basin's water [m3/s, 2D: m2/s].
struct BasinRates {
  double in = 0.0, out = 0.0;  ///< poured in and rained; drawn off and evaporated
  double spilled = 0.0;
  double gain = 0.0;  ///< of the stored volume, including what comes out of the soil
};

class PoreBoundary {
 public:
  PoreBoundary() = default;
  PoreBoundary(const PoreBoundary&) = delete;
  PoreBoundary& operator=(const PoreBoundary&) = delete;
  virtual ~PoreBoundary() = default;

  /// Begins a step, or another instant within the step. The calls below refer to these times.
  virtual void begin(const StepTimes& times) = 0;
  /// Inflow for the present variables of the flow model.
  [[nodiscard]] virtual Inflow inflow(const FlowModel& flow, const Segment& segment,
                                      const SegmentState& state) const = 0;
  /// Adds the mean inflow of the step [m3/s, 2D: m2/s] to the segment's state and to the account.
  virtual void accept(const Segment& segment, double flow, SegmentState& state, Account& account) const = 0;
  /// Elevation [m] of the water behind the boundary at the end of the step; empty for boundaries without such water.
  [[nodiscard]] virtual std::optional<double> level() const { return std::nullopt; }

  // Boundaries whose level follows from a balance: wells that pump a discharge, and basins. The balance closes at the
  // level at which wants() and the sum of inflow_at() over the segments is zero; both grow with the level.
  [[nodiscard]] virtual bool finds_level() const { return false; }
  /// low, high: elevations [m] of the lowest and highest point of its segments.
  [[nodiscard]] virtual LevelRange levels(double /*low*/, double /*high*/) const { return {}; }
  /// Sets the level [m] for inflow().
  virtual void set_level(double /*elevation*/) {}
  /// Inflow for another level [m].
  [[nodiscard]] virtual Inflow inflow_at(const FlowModel& flow, const Segment& segment, double level) const {
    return flow.below_level(segment, level);
  }
  /// Rate [m3/s, 2D: m2/s] at which a level needs water apart from the inflow into the soil: what it stores, less what
  /// is supplied. For a well: minus the inflow that it prescribes.
  [[nodiscard]] virtual double wants(double /*level [m]*/) const { return 0.0; }

  // Basins alone.
  [[nodiscard]] virtual double first_volume() const { return 0.0; }  ///< m3 (2D: m2), at time zero
  virtual void begin_stage(const BasinStage& /*stage*/) {}
  /// The rates at the present level. into_soil: sum of the inflow; at_end: whether the level is at an end of its range.
  [[nodiscard]] virtual BasinRates rates(double /*into_soil*/, bool /*at_end*/) const { return {}; }
  /// Depth of its water [m], and its area [m2, 2D: m]; without area there is no basin.
  [[nodiscard]] virtual double depth() const { return 0.0; }
  [[nodiscard]] virtual double area() const { return 0.0; }
  /// The next time [s] after `time` [s] at which a prescribed value changes its slope; infinite if none follows.
  [[nodiscard]] virtual double next_corner(double time) const = 0;
};

/// The time of the first knot of a series after `time` [s]; infinite if no knot follows.
double next_knot(const Series& series, double time);

/// The boundary for a segment along a water face and under rain: indices in the case's lists, or Segment::none.
std::unique_ptr<PoreBoundary> make_boundary(const Case& scene, std::size_t face, std::size_t rain);
/// The boundary along a well's screen.
std::unique_ptr<PoreBoundary> make_well(const Well& well);

}  // namespace poretwin::pore
