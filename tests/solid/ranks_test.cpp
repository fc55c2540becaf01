// Soil on two ranks moves as on one. Each rank has a block of soil of its own, out of the other's reach, so that no
// values pass between them: what differs from one rank was decided by one rank alone.
#include "tests/particles/ranks.hpp"
#include "tests/solid/scenes.hpp"

#include <gtest/gtest.h>

namespace poretwin::solid::test {
namespace {

using poretwin::test::ThreadRanks;

constexpr double dx = 0.05;

Soil block(double left, double right, double height) {
  Soil soil = column({}).soils[0];
  soil.shape.min = Point3(left, 0.0, 0.0);
  soil.shape.max = Point3(right, height, 0.0);
  return soil;
}

/// Two blocks on a fixed base, 2 m apart: a high one, of rank 0, and a wide one, of rank 1.
Case two_blocks() {
  Case scene = column({.spacing = dx, .sides = false});
  scene.soils = {block(0.0, 0.4, 0.8), block(2.4, 3.2, 0.4)};
  return scene;
}

struct Ran {
  ScalarArray intervals;
  std::map<std::string, double> counters;
  Particles<2> particles;
};
Ran run(Solid<2>& solid, std::size_t windows) {
  Ran out;
  solid.initialise({});
  double time = 0.0;
  for (std::uint64_t step = 0; step < windows; ++step) {
    out.intervals.push_back(std::min(0.01, solid.proposal().first));
    solid.advance({step, time, out.intervals.back()}, {});
    time += out.intervals.back();
  }
  out.counters = solid.counters();
  out.particles = solid.state().particles;
  return out;
}

/// Compares each particle with the nearest of the other run; returns its counters. The bound is far above what rounding
/// adds, and far below what a decision of one rank alone changes.
std::map<std::string, double> expect_the_same(const Case& scene, std::size_t windows) {
  constexpr double most = 1e-6;
  Solid<2> whole(scene);
  const Ran one = run(whole, windows);
  std::array<Ran, 2> parts;
  ThreadRanks two(2);
  two.run([&](std::size_t rank, const Ranks& ranks) {
    Case own = scene;
    own.soils = {scene.soils[rank]};
    Solid<2> solid(own, Domain(ranks, 0, 0));
    parts[rank] = run(solid, windows);
  });
  EXPECT_EQ(parts[0].particles.size() + parts[1].particles.size(), one.particles.size());
  double moved = 0.0, farthest = 0.0;
  for (const Ran& part : parts) {
    for (std::size_t k = 0; k < windows; ++k) EXPECT_NEAR(part.intervals[k], one.intervals[k], most * one.intervals[k]);
    for (const char* counter : {"substeps", "substeps asleep", "rest steps"})
      EXPECT_EQ(part.counters.at(counter), one.counters.at(counter)) << counter;
    for (std::size_t i = 0; i < part.particles.size(); ++i) {
      double nearest = 1e300;
      for (std::size_t j = 0; j < one.particles.size(); ++j)
        nearest = std::min(nearest, (part.particles.position[i] - one.particles.position[j]).norm() +
                                        (part.particles.displacement[i] - one.particles.displacement[j]).norm());
      moved = std::max(moved, nearest);
      farthest = std::max(farthest, part.particles.displacement[i].norm());
    }
  }
  EXPECT_GT(farthest, 1e-4 * dx);
  EXPECT_LT(moved, most * dx);
  return one.counters;
}

TEST(SolidOnRanks, TwoBlocksComeToRestAndSleepAsOnOne) {
  Case scene = two_blocks();
  scene.solid.quiet = Quiet{};
  expect_the_same(scene, 10);
}

/// Blocks that are let go swing until they are quiet, and sleep once both are.
TEST(SolidOnRanks, TwoBlocksCalmDownAndSleepAsOnOne) {
  Case scene = two_blocks();
  scene.solid.quiet = Quiet{.sleep_below = 0.02, .wake_above = 0.2};
  scene.solid.initial_rest = false;
  EXPECT_GT(expect_the_same(scene, 80).at("substeps asleep"), 0.0);
}

TEST(SolidOnRanks, TwoHeapsCollapseAsOnOne) {
  Case scene = two_blocks();
  scene.solid.model = SolidCase::Model::drucker_prager;
  for (Soil& soil : scene.soils) {
    soil.friction_angle = 31.0;
    soil.cone = Soil::Cone::repose;
  }
  scene.soils[1].cohesion = 2e4;  // stands
  scene.solid.initial_rest = false;
  scene.solid.quiet = Quiet{.regions = 5e-3};
  expect_the_same(scene, 20);
}

}  // namespace
}  // namespace poretwin::solid::test
