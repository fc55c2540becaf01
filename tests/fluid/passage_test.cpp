// Water passes over a crest and back, between the still water behind a face, which has no particles, and water
// particles.
#include "common/core/error.hpp"
#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/scenes.hpp"

#include <gtest/gtest.h>

namespace poretwin::fluid {
namespace {

using namespace test;

constexpr double dx = 0.01, g = 9.81;

/// A rigid sill with its crest at 0.1 m, on 0.05 m of wet soil of very low permeability, between a basin on its left
/// and tailwater at 0.02 m on its right.
Case sill(double length, double area, double level, double inflow) {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = dx;
  scene.soils = {sand()};
  scene.soils[0].hydraulic_conductivity = 1e-9;
  scene.soils[0].shape = box(0.0, 0.0, length, 0.05);
  scene.fluid.regions = {scene.soils[0].shape};
  scene.walls = {wall(line(0.0, 0.0, length, 0.0)), wall(line(length, 0.05, 0.0, 0.05)),
                 wall(line(0.0, 0.1, length, 0.1)), wall(line(length, 0.1, length, 0.05))};
  scene.water_faces = {head_face(line(0.0, 0.1, 0.0, 0.0), level), head_face(line(length, 0.0, length, 0.05), 0.02)};
  scene.water_faces[0].name = "basin";
  scene.water_faces[0].discharge = constant(inflow);
  scene.water_faces[0].basin_area = Series{{{0.0, area}, {1.0, area}}};
  scene.water_faces[1].name = "tailwater";
  scene.gauges = {gauge("level", "level", {}, "basin"), gauge("through", "passed_volume", {}, "basin"),
                  gauge("water", "balance"), gauge("depth", "front")};
  scene.gauges.back().points = {Point3(0.5 * length, 0.1, 0.0), Point3(0.5 * length, 0.3, 0.0)};
  return scene;
}

// Over a smooth broad crest with a free fall behind it, the discharge (2/3)^(3/2) sqrt(g) H^(3/2) has the head H above
// it.
TEST(Passage, OverABroadCrestTheDischargeIsCritical) {
  for (const double H : {0.03, 0.06, 0.09}) {
    const double q = std::pow(2.0 / 3.0, 1.5) * std::sqrt(g) * std::pow(H, 1.5), area = 0.3, start = 0.09;
    Fluid<2> fluid(sill(0.6, area, start, q));
    fluid.initialise({});
    double time = 0.0;
    for (const double end : {2.0, 6.0, 10.0}) {
      run_to(fluid, time, end);
      const double level = reading(fluid, "level");
      std::printf("%.0f s: %.5f m over the crest, of %.2f m; depth on it %.4f of %.4f m\n", end, level - 0.1, H,
                  reading(fluid, "depth"), 2.0 / 3.0 * H);
      EXPECT_NEAR(area * (level - start), q * time - reading(fluid, "through"), 1e-12);
      EXPECT_NEAR(reading(fluid, "water_error"), 0.0, 1e-12);
    }
    EXPECT_NEAR(reading(fluid, "level") - 0.1, H, 0.02 * H);
    EXPECT_NEAR(reading(fluid, "depth"), 2.0 / 3.0 * H, 0.5 * dx);
    EXPECT_EQ(fluid.counters().at("lost, far outside"), 0.0);
  }
}

TEST(Passage, FlowOverACrestKeepsEnergyOrIsCritical) {
  const auto energy = [](const SillFlow& f) { return f.depth + 0.5 * f.speed * f.speed / g; };
  const double H = 0.1, critical = std::sqrt(g * 2.0 / 3.0 * H);
  const auto free = flow_over(H, {}, g);  // a dry crest
  EXPECT_NEAR(free.depth, 2.0 / 3.0 * H, 1e-12);
  EXPECT_NEAR(free.speed, critical, 1e-12);
  const auto rest = flow_over(H, {H, 0.0}, g);
  EXPECT_NEAR(rest.depth, H, 1e-12);
  EXPECT_NEAR(rest.speed, 0.0, 1e-12);
  for (const SillFlow before : {SillFlow{0.09, 0.1}, SillFlow{0.08, 0.5}, SillFlow{0.095, 0.0}}) {
    const auto flow = flow_over(H, before, g);
    EXPECT_NEAR(energy(flow), H, 1e-12);
    EXPECT_NEAR(flow.speed - 2.0 * std::sqrt(g * flow.depth), before.speed - 2.0 * std::sqrt(g * before.depth), 1e-12);
    EXPECT_LT(flow.speed, critical);
  }
  const auto back = flow_over(H, {0.12, 0.0}, g);  // a higher level on the crest: water flows back without its energy
  EXPECT_NEAR(back.depth, H, 1e-12);
  EXPECT_NEAR(back.speed, 2.0 * (std::sqrt(g * H) - std::sqrt(g * 0.12)), 1e-12);
  EXPECT_EQ(flow_over(-0.01, {0.05, -0.3}, g).speed, 0.0);  // without still water before it, it falls freely
}

TEST(Passage, ResumesOverACrestToTheBit) {
  Fluid<2> fluid(sill(0.3, 0.1, 0.1, 0.025));
  fluid.initialise({});
  double time = 0.0;
  run_to(fluid, time, 1.5);
  ASSERT_GT(fluid.counters().at("born"), 50.0);
  Archive saved;
  fluid.archive(saved);
  Fluid<2> other(sill(0.3, 0.1, 0.1, 0.025));
  Archive bytes(saved.bytes());
  other.archive(bytes);
  double again = time;
  run_to(fluid, time, 2.0);
  run_to(other, again, 2.0);
  EXPECT_EQ(reading(fluid, "level"), reading(other, "level"));
  ASSERT_EQ(fluid.state().particles.size(), other.state().particles.size());
  for (std::size_t a = 0; a < fluid.state().particles.size(); ++a)
    EXPECT_EQ(fluid.state().particles.position[a], other.state().particles.position[a]);
}

// Water on a crest that ends at a wall comes to rest at the reservoir's level, follows it downwards, and flows into a
// reservoir below the crest.
TEST(Passage, ATankBehindASillFollowsItsReservoirAndRunsBackIntoIt) {
  auto scene = sill(0.4, 0.3, 0.05, 0.0);
  scene.walls.back() = wall(line(0.4, 0.05, 0.4, 0.4));
  scene.water_faces.pop_back();
  scene.walls.push_back(wall(line(0.4, 0.0, 0.4, 0.05)));
  auto& reservoir = scene.water_faces[0];
  reservoir.discharge.reset();
  reservoir.basin_area.reset();
  reservoir.head = Series{{{0.0, 0.05}, {4.0, 0.16}, {12.0, 0.16}, {16.0, 0.12}, {22.0, 0.12}, {23.0, 0.05}}};
  scene.gauges = {gauge("through", "passed_volume", {}, "basin"), gauge("water", "balance"),
                  gauge("kinetic", "kinetic_energy")};
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  for (const auto& [end, depth] : {std::pair{12.0, 0.06}, std::pair{22.0, 0.02}, std::pair{36.0, 0.0}}) {
    run_to(fluid, time, end);
    std::printf("%.0f s: %.4f m deep, %.2g J\n", end, reading(fluid, "through") / 0.4, reading(fluid, "kinetic"));
    EXPECT_NEAR(reading(fluid, "through") / 0.4, depth, 0.5 * dx);
    EXPECT_NEAR(reading(fluid, "water_error"), 0.0, 1e-12);
    EXPECT_EQ(fluid.counters().at("lost, far outside"), 0.0);
  }
}

TEST(Passage, WaterThatFallsIntoABasinRaisesItByItsVolume) {
  auto scene = sill(0.2, 0.5, 0.05, 0.0);
  scene.fluid.regions.push_back(box(-0.2, 0.15, -0.1, 0.25));
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  run_to(fluid, time, 0.1);
  EXPECT_NEAR(reading(fluid, "level"), 0.05, 1e-3);  // still 0.1 m above it, after falling by 0.05 m
  run_to(fluid, time, 1.0);
  std::printf("level %.8f m\n", reading(fluid, "level"));
  EXPECT_NEAR(0.5 * (reading(fluid, "level") - 0.05), -reading(fluid, "through"), 1e-12);
  EXPECT_NEAR(reading(fluid, "level"), 0.05 + 0.01 / 0.5, 1e-5);
  EXPECT_NEAR(reading(fluid, "water_out"), 0.01, 1e-6);
  EXPECT_NEAR(reading(fluid, "water_error"), 0.0, 1e-12);
  EXPECT_EQ(fluid.counters().at("lost, far outside"), 0.0);
}

}  // namespace
}  // namespace poretwin::fluid
