// Free water as particles over water in soil as a field.
#include "joint_solver/joint_water.hpp"
#include "tests/pore/scenes.hpp"

#include <gtest/gtest.h>

namespace poretwin::joint {
namespace {

using namespace pore::test;

Wall wall(Face face) {
  Wall w;
  w.face = std::move(face);
  return w;
}

Soil coarse_sand() { return van_genuchten(0.045, 0.43, 14.5, 2.68, 1e-3); }

/// Soil up to z = 0.2 m between two walls, with free water on it.
Case column(double spacing, double level) {
  Case scene = scene_of(coarse_sand(), box(0.0, 0.0, 4.0 * spacing, 0.2), spacing, 1e9);
  scene.fluid.representation = FluidCase::Representation::both;
  const double width = 4.0 * spacing;
  scene.walls = {wall(line(0.0, 1.0, 0.0, 0.0)), wall(line(width, 0.0, width, 1.0))};
  scene.fluid.regions = {box(0.0, 0.2, width, level)};
  scene.gauges = {gauge("water", "balance"), gauge("volume", "volume"), gauge("soaked", "infiltration"),
                  gauge("bed", "point", {Point3(0.5 * width, 0.2 + 0.5 * spacing, 0.0)}, "pore_pressure"),
                  gauge("soil", "point", {Point3(0.5 * width, 0.1, 0.0)}, "pressure_head")};
  return scene;
}

void run_to(JointWater& water, double& time, double end) {
  std::uint64_t step = 0;
  while (time < end * (1.0 - 1e-12)) {
    const double dt = std::min(water.proposal().first, end - time);
    ASSERT_TRUE(water.advance({step++, time, dt}, {}).accepted);
    time += dt;
  }
}

double reading(const JointWater& water, const std::string& name) {
  for (const auto& r : water.gauges())
    if (r.gauge == name) return r.value;
  throw std::runtime_error("no gauge " + name);
}

// Darcy's law in full soil of height L over a drain at its base: H' = -K (H + L) / L.
TEST(JointWater, APondOnFullSoilFallsAsInAPermeameter) {
  const double dx = 0.02, L = 0.2, H = 0.2, K = 1e-3;
  Case scene = column(dx, L + H);
  scene.water_faces = {head_face(line(0.0, 0.0, 4.0 * dx, 0.0), 0.0)};
  scene.fluid.regions.push_back(box(0.0, 0.0, 4.0 * dx, L));
  scene.fluid.initial_water_table = 1.0;
  JointWater water(scene);
  water.initialise({});
  double time = 0.0;
  for (const double end : {20.0, 50.0, 80.0}) {
    run_to(water, time, end);
    const double exact = (H + L) * std::exp(-K * end / L) - L;
    EXPECT_NEAR(water.free_water().volume() / (4.0 * dx), exact, 0.003 * H) << end;
    EXPECT_NEAR(reading(water, "water_error"), 0.0, 1e-14);
    EXPECT_NEAR(reading(water, "soaked") / (4.0 * dx), H - exact, 0.003 * H);
    EXPECT_NEAR(reading(water, "soil"), 0.5 * exact, 0.01 * H);
  }
}

// The same from below: groundwater under a head rises into the pond, H' = K (h - H - L) / L. With few rows the pressure
// before the bed is slightly too high while the pond rises.
TEST(JointWater, GroundwaterFillsAPond) {
  const double dx = 0.01, L = 0.2, H = 0.06, h = 0.4, K = 1e-3;
  Case scene = column(dx, L + H);
  scene.water_faces = {head_face(line(0.0, 0.0, 4.0 * dx, 0.0), h)};
  scene.fluid.initial_water_table = 1.0;
  JointWater water(scene);
  water.initialise({});
  double time = 0.0;
  for (const double end : {20.0, 60.0}) {
    run_to(water, time, end);
    const double exact = h - L - (h - L - H) * std::exp(-K * end / L);
    EXPECT_NEAR(water.free_water().volume() / (4.0 * dx), exact, 0.01 * (exact - H)) << end;
    EXPECT_NEAR(reading(water, "water_error"), 0.0, 1e-14);
  }
}

// Water at rest under the level of the pond stays at rest.
TEST(JointWater, AtOneHeadNothingPasses) {
  const double dx = 0.02;
  Case scene = column(dx, 0.3);
  scene.walls.push_back(wall(line(0.0, 0.0, 4.0 * dx, 0.0)));
  scene.fluid.initial_water_table = 0.3;
  JointWater water(scene);
  water.initialise({});
  double time = 0.0;
  run_to(water, time, 5.0);
  EXPECT_LT(std::abs(reading(water, "soaked")), 1e-4 * 4.0 * dx * 0.1);
  EXPECT_NEAR(reading(water, "water_error"), 0.0, 1e-14);
}

// A pond on dry sand empties; then the ground goes on with steps of its own.
TEST(JointWater, WhenThePondIsEmptyTheGroundGoesOnAlone) {
  const double dx = 0.02;
  Case scene = column(dx, 0.26);
  scene.water_faces = {head_face(line(0.0, 0.0, 4.0 * dx, 0.0), 0.0)};
  scene.fluid.initial_water_table = 0.0;
  JointWater water(scene);
  water.initialise({});
  double time = 0.0;
  run_to(water, time, 40.0);
  EXPECT_EQ(water.free_water().state().particles.size(), 0u);
  EXPECT_LT(std::abs(water.film()), 4.0 * dx * dx);
  EXPECT_NEAR(reading(water, "water_error"), 0.0, 1e-14);
  const double windows = water.counters().at("windows");
  run_to(water, time, 4000.0);
  EXPECT_LT(water.counters().at("windows"), windows + 2000.0);
  EXPECT_NEAR(reading(water, "water_error"), 0.0, 1e-14);
}

// Groundwater that comes out above the free water becomes particles and runs down to it.
TEST(JointWater, SpringsBecomeParticles) {
  const double dx = 0.02;
  Case scene = scene_of(coarse_sand(), box(0.0, 0.0, 0.4, 0.1), dx, 1e9);
  scene.soils.push_back(scene.soils[0]);
  scene.soils[1].shape = box(0.0, 0.1, 0.2, 0.3);
  scene.fluid.representation = FluidCase::Representation::both;
  scene.walls = {wall(line(0.0, 0.0, 0.4, 0.0)), wall(line(0.4, 0.0, 0.4, 0.5))};
  scene.water_faces = {head_face(line(0.0, 0.3, 0.0, 0.0), 0.29)};
  scene.fluid.regions = {box(0.2, 0.1, 0.4, 0.14)};
  scene.fluid.initial_water_table = 0.29;  // the bank drains from the start
  scene.gauges = {gauge("water", "balance")};
  JointWater water(scene);
  water.initialise({});
  const double first = water.free_water().volume();
  double time = 0.0;
  run_to(water, time, 30.0);
  EXPECT_GT(water.free_water().state().counts.born, 0.0);
  EXPECT_GT(water.free_water().volume(), first + 10.0 * dx * dx);
  EXPECT_EQ(water.free_water().state().counts.lost, 0.0);
  EXPECT_NEAR(reading(water, "water_error"), 0.0, 1e-14);
  for (const auto& part : water.free_water().state().bed) EXPECT_LT(std::abs(part.film), 1.2 * dx * dx);
}

TEST(JointWater, IsRestoredAndResumedToTheBit) {
  const double dx = 0.02;
  Case scene = column(dx, 0.3);
  scene.walls.push_back(wall(line(0.0, 0.0, 4.0 * dx, 0.0)));
  scene.fluid.initial_water_table = 0.0;
  JointWater water(scene), resumed(scene);
  water.initialise({});
  double time = 0.0;
  run_to(water, time, 0.5);
  Archive state;
  water.archive(state);
  Archive again(state.bytes());
  resumed.archive(again);
  again.expect_end();
  water.save();
  const double middle = time;
  run_to(water, time, 1.0);
  Archive once;
  water.archive(once);
  time = middle;
  run_to(resumed, time, 1.0);
  Archive other;
  resumed.archive(other);
  EXPECT_EQ(once.bytes(), other.bytes());
  water.restore();
  time = middle;
  run_to(water, time, 1.0);
  Archive twice;
  water.archive(twice);
  EXPECT_EQ(once.bytes(), twice.bytes());
}

}  // namespace
}  // namespace poretwin::joint
