// The state of the pore water, as checkpoints store it.
#pragma once

#include "pore_solver/boundary/pore_boundary.hpp"

namespace poretwin::pore {

/// Counters since the start of the run.
struct Counts {
  double iterations = 0.0, linear_iterations = 0.0;  ///< Newton iterations; iterations of the linear solves
  double carried = 0.0, links = 0.0;  ///< number of times that the soil moved the points; number of times that the
                                      ///< points were linked anew
};

/// Soil that moves, during one step.
struct Skeleton {
  /// pores: volume of each point's pores [m3, 2D: m2] at the step's start; found: at its end, as the last pass through
  /// the window found it (in the first pass equal to pores). head, found_head: heads [m] that the skeleton bears at
  /// these two instants.
  ScalarArray pores, found, head, found_head;
  ScalarArray give;          ///< m2 (2D: m), increase of each point's pores per metre of head
  ScalarArray conductivity;  ///< m/s
};

/// Water of a basin [m3, 2D: m2].
struct BasinWater {
  double stored = 0.0, first = 0.0;           ///< now, and at time zero
  double in = 0.0, out = 0.0, spilled = 0.0;  ///< since then: poured in and rained; drawn off and evaporated
};

struct State {
  double time = 0.0;     ///< s
  ScalarArray water;     ///< m3 (2D: m2), volume of water, conserved to rounding
  ScalarArray pores;     ///< m3 (2D: m2), volume of pores; in soil that moves, as predicted by the last step
  ScalarArray variable;  ///< variable of the flow model
  std::vector<SegmentState> segments;
  std::vector<Account> accounts;  ///< of each boundary
  ScalarArray inflow;             ///< m3/s (2D: m2/s), through each segment in the last step
  ScalarArray flow;               ///< m3/s (2D: m2/s), through each link from a to b in the last step
  /// Of each boundary whose level follows from a balance (basins, wells that pump a prescribed discharge): its level
  /// [m], and its water; wells store none.
  ScalarArray level;
  std::vector<BasinWater> basin;
  double wanted = 0.0;        ///< s, length of the next step that the error allows
  double largest_head = 0.0;  ///< m, largest head that the skeleton has borne at any point so far (soil that moves)
  /// In soil that moves, at rest at time zero: volume fraction of the grains, conductivity [m/s].
  ScalarArray rest_solid, rest_conductivity;
  /// In soil that can yield [m]: present positions, and positions when the points were last linked. Empty: as drawn.
  std::vector<Point3> position, linked;
  double last_interval = 0.0;  ///< s, of the last step; 0 before the first
  double initial_water = 0.0;  ///< m3 (2D: m2), volume of water at time zero
  Counts counts;
};

}  // namespace poretwin::pore
