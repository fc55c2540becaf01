// Every gauge of the water where the exact reading is known: water at rest in moist soil, level flow through it.
#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/scenes.hpp"

#include <gtest/gtest.h>

namespace poretwin::fluid {
namespace {

using namespace test;

constexpr double dx = 0.01;

/// Soil of 0.4 x 0.3 m, whose pores hold water in a tenth of their volume at first.
Case moist_soil() {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = dx;
  scene.soils = {sand()};
  scene.soils[0].initial_saturation = 0.1;
  scene.soils[0].shape = box(0.0, 0.0, 0.4, 0.3);
  return scene;
}

// A water table inside the soil, at rest from the first window on.
TEST(Gauges, OfAWaterTableAtRest) {
  auto scene = moist_soil();
  scene.fluid.regions = {box(0.0, 0.0, 0.4, 0.2)};
  scene.walls = {wall(line(0.0, 0.3, 0.0, 0.0)), wall(line(0.0, 0.0, 0.4, 0.0)), wall(line(0.4, 0.0, 0.4, 0.3))};
  scene.gauges = {gauge("head", "point", {{0.1, 0.05, 0.0}, {0.3, 0.15, 0.0}, {0.2, 0.0, 0.0}}, "head"),
                  gauge("pressure", "point", {{0.1, 0.05, 0.0}}, "pore_pressure"),
                  gauge("pressure_head", "point", {{0.3, 0.15, 0.0}}, "pressure_head"),
                  gauge("dry", "point", {{0.2, 0.27, 0.0}}, "head"),
                  gauge("saturation", "point", {{0.2, 0.1, 0.0}, {0.2, 0.27, 0.0}}, "degree_of_saturation"),
                  gauge("table", "front", {{0.2, 0.0, 0.0}, {0.2, 0.3, 0.0}}),
                  gauge("lowest", "min_pressure"),
                  gauge("speed", "max_speed"),
                  gauge("volume", "volume"),
                  gauge("left_half", "volume"),
                  gauge("potential", "potential_energy"),
                  gauge("energy", "energy"),
                  gauge("particles", "particles"),
                  gauge("water", "balance"),
                  gauge("momentum", "momentum", {}, "momentum_y")};
  scene.gauges[9].region = box(0.0, 0.0, 0.2, 0.3);
  Fluid<2> fluid(scene);
  fluid.initialise({});
  const double stored = 0.4 * 0.9 * 0.4 * 0.2;  // m2
  double time = 0.0;
  for (const double end : {0.0, 1.0, 500.0}) {
    if (end > 0.0) run_to(fluid, time, end);
    for (const auto* point : {"head[0]", "head[1]", "head[2]"}) EXPECT_NEAR(reading(fluid, point), 0.2, 1e-5) << end;
    EXPECT_NEAR(reading(fluid, "pressure"), 9810.0 * 0.15, 0.1) << end;
    EXPECT_NEAR(reading(fluid, "pressure_head"), 0.05, 1e-5) << end;
    EXPECT_TRUE(std::isnan(reading(fluid, "dry"))) << end;
    EXPECT_NEAR(reading(fluid, "saturation[0]"), 1.0, 0.02) << end;  // between the sites of a lattice
    EXPECT_EQ(reading(fluid, "saturation[1]"), 0.1) << end;
    EXPECT_NEAR(reading(fluid, "table"), 0.2, 0.05 * dx) << end;
    EXPECT_NEAR(reading(fluid, "lowest"), 9810.0 * 0.5 * dx, 0.1) << end;
    EXPECT_NEAR(reading(fluid, "speed"), 0.0, 1e-10) << end;
    EXPECT_NEAR(reading(fluid, "momentum_y"), 0.0, 1e-9) << end;
    EXPECT_THROW(reading(fluid, "momentum_x"), std::runtime_error) << end;  // not asked for
    EXPECT_NEAR(reading(fluid, "volume") / stored, 1.0, 1e-12) << end;
    EXPECT_NEAR(reading(fluid, "left_half") / stored, 0.5, 1e-12) << end;
    EXPECT_NEAR(reading(fluid, "potential") / (9810.0 * stored * 0.1), 1.0, 1e-9) << end;
    EXPECT_NEAR(reading(fluid, "energy") / reading(fluid, "potential"), 1.0, 1e-9) << end;
    EXPECT_EQ(reading(fluid, "particles"), 800.0) << end;
    EXPECT_NEAR(reading(fluid, "water_error"), 0.0, 1e-15) << end;
  }
}

// Upward flow with the gradient i = 0.5 through a bed that looks upwards, whose critical gradient is
// (1 - n)(rho_s / rho_w - 1) = 0.6 * 1.5 = 0.9.
TEST(Gauges, OfUpwardFlowTellTheGradientOverTheCriticalOne) {
  auto scene = moist_soil();
  scene.soils[0].initial_saturation = 0.0;
  scene.soils[0].porosity = 0.4;
  scene.soils[0].grain_density = 2500.0;
  scene.fluid.regions = {scene.soils[0].shape};
  scene.walls = {wall(line(0.0, 0.3, 0.0, 0.0)), wall(line(0.4, 0.0, 0.4, 0.3))};
  scene.water_faces = {head_face(line(0.0, 0.0, 0.4, 0.0), 0.45), head_face(line(0.4, 0.3, 0.0, 0.3), 0.3)};
  scene.gauges = {gauge("bed", "exit_gradient", {{0.4, 0.3, 0.0}, {0.0, 0.3, 0.0}}),
                  gauge("below", "exit_gradient", {{0.0, 0.0, 0.0}, {0.4, 0.0, 0.0}}),
                  gauge("heave", "heave", {{0.05, 0.1, 0.0}, {0.35, 0.1, 0.0}})};
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  run_to(fluid, time, 10.0);
  EXPECT_NEAR(reading(fluid, "bed"), 0.5, 0.01);
  EXPECT_NEAR(reading(fluid, "bed_over_critical"), 0.5 / 0.9, 0.01);
  EXPECT_NEAR(reading(fluid, "below"), -0.5, 0.01);
  // 0.3 m of water push from below, 0.2 m of soil weigh 0.6 * 2.5 + 0.4 = 1.9 times as much as water. At the critical
  // gradient 0.9 it would be 1.
  EXPECT_NEAR(reading(fluid, "heave"), 0.3 / 0.38, 0.01);
  for (const auto& r : fluid.gauges()) EXPECT_NE(r.gauge, "below_over_critical");
}

// Level flow between two reservoirs under a lid: hydraulic gradient i = 0.25, discharge q = k i h.
TEST(Gauges, OfLevelFlow) {
  auto scene = moist_soil();
  scene.soils[0].initial_saturation = 0.0;
  scene.fluid.regions = {scene.soils[0].shape};
  scene.walls = {wall(line(0.0, 0.0, 0.4, 0.0)), wall(line(0.4, 0.3, 0.0, 0.3))};
  scene.water_faces = {head_face(line(0.0, 0.3, 0.0, 0.0), 0.5), head_face(line(0.4, 0.0, 0.4, 0.3), 0.4)};
  scene.water_faces[0].name = "left";
  scene.water_faces[1].name = "right";
  scene.gauges = {gauge("to_the_right", "discharge", {{0.2, 0.3, 0.0}, {0.2, 0.0, 0.0}}),
                  gauge("to_the_left", "discharge", {{0.2, 0.0, 0.0}, {0.2, 0.3, 0.0}}),
                  gauge("upper_half", "discharge", {{0.2, 0.3, 0.0}, {0.2, 0.15, 0.0}}),
                  gauge("in", "exit_gradient", {{0.0, 0.3, 0.0}, {0.0, 0.0, 0.0}}),
                  gauge("out", "exit_gradient", {{0.4, 0.0, 0.0}, {0.4, 0.3, 0.0}}),
                  gauge("lift", "pressure_force", {{0.0, 0.3, 0.0}, {0.4, 0.3, 0.0}}),
                  gauge("head", "point", {{0.1, 0.1, 0.0}, {0.3, 0.2, 0.0}}, "head"),
                  gauge("velocity", "point", {{0.2, 0.1, 0.0}}, "velocity"),
                  gauge("left", "passed_volume", {}, "left"),
                  gauge("right", "passed_volume", {}, "right"),
                  gauge("all", "passed_volume"),
                  gauge("momentum", "momentum"),
                  gauge("kinetic", "kinetic_energy"),
                  gauge("water", "balance")};
  Fluid<2> fluid(scene);
  fluid.initialise({});
  const double q = 1.1e-4 * 0.25 * 0.3, v = 1.1e-4 * 0.25 / 0.4, mass = 1000.0 * 0.4 * 0.4 * 0.3;
  double time = 0.0;
  run_to(fluid, time, 40.0);
  EXPECT_NEAR(reading(fluid, "to_the_right") / q, 1.0, 2e-3);
  EXPECT_NEAR(reading(fluid, "to_the_left") / q, -1.0, 2e-3);
  EXPECT_NEAR(reading(fluid, "upper_half") / q, 0.5, 2e-3);
  EXPECT_NEAR(reading(fluid, "out"), 0.25, 0.0025);
  EXPECT_NEAR(reading(fluid, "in"), -0.25, 0.0025);  // inflow has a negative gradient
  EXPECT_GT(reading(fluid, "out_at"), 0.0);
  EXPECT_LT(reading(fluid, "out_at"), 0.3);
  for (const auto& r : fluid.gauges()) EXPECT_NE(r.gauge, "out_over_critical") << "an upright face lets no grains rise";
  // On the lid the head over it falls from 0.2 to 0.1 m.
  EXPECT_NEAR(reading(fluid, "lift") / (9810.0 * 0.15 * 0.4), 1.0, 2e-3);
  EXPECT_NEAR(reading(fluid, "lift_at"), 0.4 / 3.0 * (0.2 + 2.0 * 0.1) / (0.2 + 0.1), 1e-3);
  EXPECT_NEAR(reading(fluid, "head[0]"), 0.475, 1e-4);
  EXPECT_NEAR(reading(fluid, "head[1]"), 0.425, 1e-4);
  EXPECT_NEAR(reading(fluid, "velocity_x") / v, 1.0, 2e-3);
  EXPECT_NEAR(reading(fluid, "velocity_y") / v, 0.0, 2e-3);
  EXPECT_NEAR(reading(fluid, "momentum_x") / (mass * v), 1.0, 0.03);  // outermost row varies
  EXPECT_NEAR(reading(fluid, "kinetic") / (0.5 * mass * v * v), 1.0, 0.03);
  EXPECT_NEAR(reading(fluid, "left") / (q * time), 1.0, 5e-3);
  EXPECT_NEAR(reading(fluid, "right") / (q * time), -1.0, 5e-3);
  EXPECT_NEAR(reading(fluid, "all"), reading(fluid, "left") + reading(fluid, "right"), 1e-15);
  EXPECT_NEAR(reading(fluid, "water_in") - reading(fluid, "water_out"), reading(fluid, "all"), 1e-12);
  EXPECT_NEAR(reading(fluid, "water_in") / (q * time), 1.0, 5e-3);
  EXPECT_NEAR(reading(fluid, "water_stored") / (0.4 * 0.4 * 0.3), 1.0, 1e-3);
  EXPECT_NEAR(reading(fluid, "water_error"), 0.0, 1e-12);
}

/// Two soils of 0.4 x 0.3 m together, the second of a hundredth of the first one's conductivity, full of water.
Case two_soils(const Shape& first, const Shape& second) {
  auto scene = moist_soil();
  scene.soils[0].initial_saturation = 0.0;
  scene.soils[0].hydraulic_conductivity = 1e-3;
  scene.soils.push_back(scene.soils[0]);
  scene.soils[0].shape = first;
  scene.soils[1].shape = second;
  scene.soils[1].hydraulic_conductivity = 1e-5;
  scene.fluid.regions = {box(0.0, 0.0, 0.4, 0.3)};
  scene.walls = {wall(line(0.0, 0.0, 0.4, 0.0)), wall(line(0.4, 0.3, 0.0, 0.3))};
  scene.water_faces = {head_face(line(0.0, 0.3, 0.0, 0.0), 0.5), head_face(line(0.4, 0.0, 0.4, 0.3), 0.4)};
  return scene;
}

// Soils in series: the head falls by 0.1 m, all but 1 % of it in the second soil, and its slope jumps at the border. A
// fit to particles on both sides read up to 1.7 mm too little in the first soil, a third of what the other has over one
// spacing.
TEST(Gauges, BesideABorderAcrossTheFlowReadTheHeadOfTheirOwnSoil) {
  const double border = 0.2;  // between two rows: elsewhere the border is known to half a spacing
  auto scene = two_soils(box(0.0, 0.0, border, 0.3), box(border, 0.0, 0.4, 0.3));
  const std::vector<double> beside{-0.3, -0.05, 0.05, 0.3};  // spacings
  std::vector<Point3> points;
  for (const double d : beside) points.emplace_back(border + d * dx, 0.15, 0.0);
  scene.gauges = {gauge("head", "point", points, "head")};
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  run_to(fluid, time, 100.0);
  const double resistance = border / 1e-3 + (0.4 - border) / 1e-5, speed = 0.1 / resistance;
  for (std::size_t i = 0; i < beside.size(); ++i) {
    const double right = 0.5 - speed * (border / 1e-3 + beside[i] * dx / (beside[i] < 0.0 ? 1e-3 : 1e-5));
    EXPECT_NEAR(reading(fluid, "head[" + std::to_string(i) + "]"), right, 3e-4) << beside[i];
  }
}

// Soils side by side: the velocity jumps at the border by the ratio of the conductivities, and a section is passed by
// the sum of both soils' flows, whose number of rows is no whole number.
TEST(Gauges, OfTwoSoilsSideBySideReadTheFlowOfEach) {
  const double border = 0.143, slope = 0.25;
  auto scene = two_soils(box(0.0, 0.0, 0.4, border), box(0.0, border, 0.4, 0.3));
  scene.gauges = {
      gauge("velocity", "point", {{0.2, border - 0.3 * dx, 0.0}, {0.2, border + 0.3 * dx, 0.0}}, "velocity"),
      gauge("all", "discharge", {{0.2, 0.3, 0.0}, {0.2, 0.0, 0.0}}),
      gauge("first", "discharge", {{0.2, border, 0.0}, {0.2, 0.0, 0.0}})};
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  run_to(fluid, time, 5.0);
  EXPECT_NEAR(reading(fluid, "velocity[0]_x") / (slope * 1e-3 / 0.4), 1.0, 0.03);
  EXPECT_NEAR(reading(fluid, "velocity[1]_x") / (slope * 1e-5 / 0.4), 1.0, 0.5);
  const double right = slope * (border * 1e-3 + (0.3 - border) * 1e-5);
  EXPECT_NEAR(reading(fluid, "all") / right, 1.0, 0.03);
  EXPECT_NEAR(reading(fluid, "first") / (slope * border * 1e-3), 1.0, 0.03);
}

}  // namespace
}  // namespace poretwin::fluid
