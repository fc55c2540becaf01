// The pore water's state: what a checkpoint keeps.
#pragma once

#include "pore_solver/boundary/pore_boundary.hpp"

namespace poretwin::pore {

/// What happened so far.
struct Counts {
  double iterations = 0.0, linear_iterations = 0.0;  ///< of Newton; of the linear solves
};

struct State {
  double time = 0.0;     ///< s
  ScalarArray water;     ///< m3 (2D: m2), at each point; conserved to rounding
  ScalarArray variable;  ///< of each point, as the flow model has it
  std::vector<SegmentState> segments;
  std::vector<Account> accounts;  ///< of each boundary
  ScalarArray inflow;             ///< through each segment in the last step, m3/s (2D: m2/s)
  ScalarArray flow;               ///< through each link, a to b, likewise
  double wanted = 0.0;            ///< s, the step that the error allows next
  double initial_water = 0.0;     ///< m3 (2D: m2)
  Counts counts;
};

}  // namespace poretwin::pore
