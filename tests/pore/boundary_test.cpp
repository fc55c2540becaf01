// Inflow and outflow through each kind of boundary.
#include "tests/pore/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace poretwin::pore::test {
namespace {

constexpr double dx = 0.05;

TEST(PoreBoundary, AReservoirFillsTheSoilToItsLevel) {
  for (const bool capillary : {true, false}) {
    Case scene =
        scene_of(capillary ? van_genuchten(0.05, 0.4, 3.5, 2.8, 1e-3) : sharp(0.4, 1e-3), box(0, 0, 1, 1), dx, 1e6);
    scene.fluid.initial_water_table = -1.0;
    scene.water_faces = {head_face(line(0, 1, 0, 0), 0.62)};
    scene.gauges = {gauge("table", "front", {{0.5, 0, 0}, {0.5, 1, 0}})};
    PoreWater water(scene);
    run_to(water, 1e6);
    EXPECT_NEAR(reading(water, "table"), 0.62, 0.1 * dx) << capillary;
  }
}

// Upward flow with the gradient 0.5 through a bed whose critical gradient is (1 - n)(rho_s / rho_w - 1) = 0.6 * 1.5 =
// 0.9.
TEST(PoreBoundary, TheExitGradientIsToldOverTheCriticalOne) {
  Soil sand = sharp(0.4, 1e-3);
  sand.grain_density = 2500.0;
  Case scene = column(sand, 1.0, dx, 1e4);
  scene.fluid.initial_water_table = 1.0;
  scene.water_faces = {pressure_face(base_of(dx), 1.5), pressure_face(top_of(dx, 1.0), 0.0)};
  scene.gauges = {gauge("bed", "exit_gradient", top_of(dx, 1.0).points),
                  gauge("below", "exit_gradient", base_of(dx).points),
                  gauge("heave", "heave", line(0.1 * dx, 0.2, 0.9 * dx, 0.2).points),
                  gauge("push", "pressure_force", up(0.5 * dx, {0.2, 0.8}))};
  PoreWater water(scene);
  run_to(water, 1e4);
  EXPECT_NEAR(reading(water, "bed"), 0.5, 1e-3);
  EXPECT_NEAR(reading(water, "bed_over_critical"), 0.5 / 0.9, 1e-3);
  EXPECT_NEAR(reading(water, "bed_at"), 0.5 * dx, 1e-9);
  for (const auto& r : water.gauges()) EXPECT_NE(r.gauge, "below_over_critical");
  // 1.2 m of water push from below, 0.8 m of soil weigh 0.6 * 2.5 + 0.4 = 1.9 times as much as water.
  EXPECT_NEAR(reading(water, "heave"), 1.2 / (0.8 * 1.9), 2e-3);
  // On an upright line the pressure falls by 1.5 m of water over 1 m, from 1.2 m at 0.2 m to 0.3 m at 0.8 m.
  EXPECT_NEAR(reading(water, "push") / (9810.0 * 0.75 * 0.6), 1.0, 1e-3);
  EXPECT_NEAR(reading(water, "push_at"), 0.6 / 3.0 * (1.2 + 2.0 * 0.3) / (1.2 + 0.3), 1e-3);
}

TEST(PoreBoundary, ThroughAnOutletWaterOnlyLeaves) {
  Case scene = column(van_genuchten(0.05, 0.4, 3.5, 2.8, 1e-3), 1.0, dx, 1e5);
  WaterFace drain;
  drain.face = base_of(dx);
  drain.outlet = true;
  scene.water_faces = {drain};
  scene.gauges = {gauge("passed", "passed_volume"), gauge("table", "front", {{0.02, 0, 0}, {0.02, 1, 0}})};
  scene.fluid.initial_water_table = -0.5;  // dry: nothing enters
  PoreWater dry(scene);
  run_to(dry, 1e5);
  EXPECT_EQ(reading(dry, "passed"), 0.0);
  scene.fluid.initial_water_table = 0.8;  // drains until its water table is at the drain
  scene.general.end_time = 1e7;
  PoreWater wet(scene);
  run_to(wet, 1e7);
  EXPECT_LT(reading(wet, "passed"), 0.0);
  EXPECT_NEAR(reading(wet, "table"), 0.0, 0.1 * dx);
}

TEST(PoreBoundary, RainThatCannotSoakInRunsOff) {
  const double rate = 1e-4, k = 1e-6, end = 1e5;
  Case scene = column(van_genuchten(0.05, 0.4, 2.0, 2.0, k), 1.0, dx, end);
  scene.fluid.initial_water_table = 0.0;
  scene.water_faces = {head_face(base_of(dx), 0.0)};
  scene.rains = {rain(top_of(dx, 1.0), constant(rate))};
  scene.gauges = {gauge("soaked", "infiltration"), gauge("runoff", "runoff"),
                  gauge("q", "discharge", {{-1, 0.3, 0}, {1, 0.3, 0}})};
  PoreWater water(scene);
  run_to(water, end);
  EXPECT_NEAR(reading(water, "soaked") + reading(water, "runoff"), rate * end * dx, 1e-9 * rate * end * dx);
  scene.general.end_time = 1e7;
  PoreWater steady(scene);
  run_to(steady, 1e7);
  EXPECT_NEAR(-reading(steady, "q"), k * dx, 1e-3 * k * dx);  // saturated, with a gradient of one
}

TEST(PoreBoundary, APondKeepsWhatItHoldsAndLetsItSoakIn) {
  const double rate = 1e-5, stops = 3600.0, k = 1e-6, depth = 0.02;
  Case scene = column(van_genuchten(0.05, 0.4, 2.0, 2.0, k), 1.0, dx, 1e5);
  scene.fluid.initial_water_table = 0.0;
  scene.rains = {rain(top_of(dx, 1.0), Series{{{0.0, rate}, {stops, rate}, {stops + 0.001, 0.0}}})};
  scene.rains[0].ponding_depth = depth;
  scene.gauges = {gauge("soaked", "infiltration"), gauge("runoff", "runoff")};
  PoreWater water(scene);
  run_to(water, stops);
  double pond = 0.0;
  for (const auto& s : water.state().segments) pond += s.pond;
  EXPECT_GT(pond, 0.0);
  EXPECT_LE(pond, depth * dx * (1.0 + 1e-12));
  const double before = reading(water, "soaked");
  EXPECT_NEAR(before + reading(water, "runoff") + pond, rate * stops * dx, 1e-9 * rate * stops * dx);
  run_to(water, 1e5);
  EXPECT_NEAR(reading(water, "soaked"), before + pond, 1e-6 * pond);  // finally all of it
}

TEST(PoreBoundary, EvaporationEndsWhereTheSoilIsTooDry) {
  const double rate = -1e-7;
  Case scene = column(van_genuchten(0.05, 0.4, 3.5, 2.8, 5e-5), 0.5, dx, 5e6);
  scene.fluid.initial_water_table = 0.0;
  scene.rains = {rain(top_of(dx, 0.5), constant(rate))};
  scene.rains[0].limit_suction = 2.0;
  scene.gauges = {gauge("vapour", "evaporation"), gauge("balance", "balance"),
                  gauge("psi", "point", {{0.02, 0.475, 0}}, "pressure_head")};
  PoreWater water(scene);
  run_to(water, 1e5);
  EXPECT_NEAR(reading(water, "vapour"), 1e-7 * 1e5 * dx, 1e-9 * dx);  // at the prescribed rate, at first
  run_to(water, 5e6);
  EXPECT_LT(reading(water, "vapour"), 0.5 * 1e-7 * 5e6 * dx);
  EXPECT_GT(reading(water, "psi"), -2.0 - 1e-6);
  EXPECT_NEAR(reading(water, "balance_error"), 0.0, 1e-12 * dx);
}

TEST(PoreBoundary, ADamsDischargeIsDupuits) {
  // q = k (H1^2 - H2^2) / (2 L), exact for the discharge of a dam with vertical faces (Charny 1951).
  Case scene = scene_of(sharp(0.4, 1.1e-4), box(0, 0, 0.3, 0.34), 0.01, 2e4);
  scene.water_faces = {head_face(line(0, 0.34, 0, 0), 0.3), head_face(line(0.3, 0, 0.3, 0.34), 0.1)};
  scene.gauges = {gauge("q", "discharge", {{0.15, 0.34, 0}, {0.15, 0, 0}})};
  PoreWater water(scene);
  run_to(water, 2e4);
  EXPECT_NEAR(reading(water, "q") / (1.1e-4 * (0.09 - 0.01) / 0.6), 1.0, 0.01);
}

}  // namespace
}  // namespace poretwin::pore::test
