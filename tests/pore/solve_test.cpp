// The linear solves of water in full soil.
#include "tests/pore/scenes.hpp"

#include <gtest/gtest.h>

namespace poretwin::pore::test {
namespace {

/// Mean number of iterations of the linear solves as the heads around a floor change: water seeps from the bed on its
/// left to that on its right, through full soil on an impermeable base.
double iterations_a_solve(double dx) {
  Case scene = scene_of(sharp(0.4, 1e-4), box(0.0, 0.0, 2.0, 1.0), dx, 1e4);
  scene.fluid.initial_water_table = 1.5;
  scene.water_faces = {head_face(line(0.5, 1.0, 0.0, 1.0), 2.0), head_face(line(2.0, 1.0, 1.5, 1.0), 1.5)};
  PoreWater water(scene);
  run_to(water, scene.general.end_time);
  const Counts& counts = water.state().counts;
  EXPECT_GT(counts.iterations, 0.0);
  return counts.linear_iterations / counts.iterations;
}

TEST(PoreWaterSolves, IterationsInFullSoilHardlyGrowWithTheNumberOfPoints) {
  EXPECT_LT(iterations_a_solve(0.02), 13.0);
  EXPECT_LT(iterations_a_solve(0.01), 13.0);
}

}  // namespace
}  // namespace poretwin::pore::test
