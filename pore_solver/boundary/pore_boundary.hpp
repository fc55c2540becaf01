// Inflow through a segment of the soil's border: one class for each kind of boundary, each in a file of its own.
#pragma once

#include "common/case/case.hpp"
#include "pore_solver/flow.hpp"

#include <memory>
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
  /// The inflow [m3/s, 2D: m2/s] into the soil that a well prescribes. The well's level follows from it (set_level).
  [[nodiscard]] virtual std::optional<double> prescribed_inflow() const { return std::nullopt; }
  virtual void set_level(double /*elevation [m]*/) {}
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
