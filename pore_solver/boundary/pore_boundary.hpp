// What a segment of the soil's border lets in: one type a kind, each in a file of its own.
#pragma once

#include "common/case/case.hpp"
#include "pore_solver/flow.hpp"

#include <memory>
#include <span>
#include <vector>

namespace poretwin::pore {

/// What a boundary keeps of one segment, part of the saved state.
struct SegmentState {
  double pond = 0.0;  ///< m3 (2D: m2), water that stands on the surface there
};

/// Volumes since the start [m3, 2D: m2].
struct Account {
  double in = 0.0, out = 0.0;  ///< what came through water faces; what left as water, under rain, too
  double infiltration = 0.0;   ///< of rain
  double evaporation = 0.0;    ///< of the soil's water
  double runoff = 0.0;         ///< what could neither soak in nor pond; no water of the soil
  /// What the soil gained by all of it.
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

  /// What follows is of a step, and of an instant within it [s].
  virtual void begin(const StepTimes& times) = 0;
  /// What flows in at the variables that the model has.
  [[nodiscard]] virtual Inflow inflow(const FlowModel& flow, const Segment& segment,
                                      const SegmentState& state) const = 0;
  /// Takes note of the step's mean flow in [m3/s, 2D: m2/s].
  virtual void accept(const Segment& segment, double flow, SegmentState& state, Account& account) const = 0;
  /// Elevation of the water behind it [m], at the end of the step; of those that have one.
  [[nodiscard]] virtual std::optional<double> level() const { return std::nullopt; }
  /// The next instant after a time [s] at which what it prescribes has a corner.
  [[nodiscard]] virtual double next_corner(double time) const = 0;
};

/// The first of a series' knots after a time [s].
double next_knot(const Series& series, double time);

/// The kind that the case's faces and rain along a segment ask for.
std::unique_ptr<PoreBoundary> make_boundary(const Case& scene, std::size_t face, std::size_t rain);

}  // namespace poretwin::pore
