// The gauges of the field: values at points and along lines, flows, volumes, the water balance.
#pragma once

#include "common/coupling/phase.hpp"
#include "pore_solver/output/probes.hpp"
#include "pore_solver/step.hpp"

#include <array>
#include <map>

namespace poretwin::pore {

/// Fraction of a point's pores that is filled with water. Only pores that water can fill count.
inline double saturation(const State& state, Index a) { return state.water[a] / state.pores[a]; }

class Gauges {
 public:
  Gauges(const Case& scene, const Network& network);
  [[nodiscard]] std::vector<GaugeReading> read(const FlowModel& flow, const Stepper& stepper, const State& state) const;

 private:
  /// A link that crosses a line or section. sign: 1 if the link leads from the line's right to its left, or through the
  /// section along its normal; else -1.
  struct Crossing {
    std::size_t link = 0;
    double sign = 1.0;
  };
  /// The parts of a gauge that do not change in time.
  struct Places {
    std::vector<std::optional<Probe>> points;
    ProbeLine line;
    std::vector<Crossing> crossings;
    std::vector<std::size_t> segments;  ///< segments along a face
    std::vector<ProbeLine> above;       ///< lines from places upwards through the soil
    std::array<ProbeLine, 2> beside;    ///< the face moved into the soil by one and two depths
  };
  class Reader;

  const Case& scene_;
  const Network& network_;
  std::vector<Places> places_;  ///< of each gauge of the case
};

}  // namespace poretwin::pore
