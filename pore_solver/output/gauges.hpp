// What is read off the field: values at points and along lines, flows, volumes, the balance.
#pragma once

#include "common/coupling/phase.hpp"
#include "pore_solver/output/probes.hpp"
#include "pore_solver/step.hpp"

#include <array>
#include <map>

namespace poretwin::pore {

/// Share of a point's pores that its water fills, of those that water can fill.
inline double saturation(const State& state, Index a) { return state.water[a] / state.pores[a]; }

class Gauges {
 public:
  Gauges(const Case& scene, const Network& network);
  [[nodiscard]] std::vector<GaugeReading> read(const FlowModel& flow, const Stepper& stepper, const State& state) const;

 private:
  /// A link that a line crosses, and whether from its right to its left.
  struct Crossing {
    std::size_t link = 0;
    double sign = 1.0;
  };
  /// What of a gauge does not change in time.
  struct Places {
    std::vector<std::optional<Probe>> points;
    ProbeLine line;
    std::vector<Crossing> crossings;
    std::vector<std::size_t> segments;  ///< along a face
    std::array<ProbeLine, 2> beside;    ///< the face, moved inwards by a depth and by twice as much
  };
  class Reader;

  const Case& scene_;
  const Network& network_;
  std::vector<Places> places_;  ///< of each gauge of the case
};

}  // namespace poretwin::pore
