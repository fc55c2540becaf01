// The pore water's state: what a checkpoint keeps.
#pragma once

#include "pore_solver/boundary/pore_boundary.hpp"

namespace poretwin::pore {

/// What happened so far.
struct Counts {
  double iterations = 0.0, linear_iterations = 0.0;  ///< of Newton; of the linear solves
  double carried = 0.0, links = 0.0;  ///< times the soil carried the points along; times they were linked anew
};

/// Soil that moves, in one step.
struct Skeleton {
  /// Pores [m3, 2D: m2] at the step's start, and at its end as the last pass through the window found them (in the
  /// first pass those of the start), with the heads [m] that the skeleton bears there.
  ScalarArray pores, found, head, found_head;
  ScalarArray give;          ///< m2 (2D: m), of the pores for each metre of head
  ScalarArray conductivity;  ///< m/s
};

struct State {
  double time = 0.0;     ///< s
  ScalarArray water;     ///< m3 (2D: m2), at each point; conserved to rounding
  ScalarArray pores;     ///< m3 (2D: m2), at each point; of soil that moves as the last step predicted them
  ScalarArray variable;  ///< of each point, as the flow model has it
  std::vector<SegmentState> segments;
  std::vector<Account> accounts;  ///< of each boundary
  ScalarArray inflow;             ///< through each segment in the last step, m3/s (2D: m2/s)
  ScalarArray flow;               ///< through each link, a to b, likewise
  double wanted = 0.0;            ///< s, the step that the error allows next
  double largest_head = 0.0;      ///< m, that the skeleton of soil that moves has borne anywhere
  /// Of soil that moves, at its rest at time zero: share of the grains, conductivity [m/s].
  ScalarArray rest_solid, rest_conductivity;
  /// Of soil that can yield, m: where the points are; where they were when they were linked last. Empty: as drawn.
  std::vector<Point3> position, linked;
  double last_interval = 0.0;  ///< s, of the last step; 0 before the first
  double initial_water = 0.0;  ///< m3 (2D: m2)
  Counts counts;
};

}  // namespace poretwin::pore
