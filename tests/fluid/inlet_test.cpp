// Free water that enters and leaves: inlets by discharge, reservoirs that follow a head; and walls with convex corners.
#include "common/core/error.hpp"
#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/scenes.hpp"

#include <gtest/gtest.h>

namespace poretwin::fluid {
namespace {

using namespace test;

constexpr double dx = 0.02;

/// A tank 0.4 m wide with an opening in its floor, from 0 to 0.2 m.
Case tank() {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = dx;
  scene.walls = {wall(line(0.0, 1.0, 0.0, 0.0)), wall(line(0.2, 0.0, 0.4, 0.0)), wall(line(0.4, 0.0, 0.4, 1.0))};
  WaterFace opening;
  opening.name = "opening";
  opening.face = line(0.0, 0.0, 0.2, 0.0);
  scene.water_faces = {opening};
  scene.gauges = {gauge("water", "balance"), gauge("level", "level", {}, "opening"),
                  gauge("through", "passed_volume", {}, "opening"), gauge("kinetic", "kinetic_energy")};
  return scene;
}

/// Twice the height of the water's centre: the level in a tank with vertical walls.
double level(const Fluid<2>& fluid) {
  const auto& p = fluid.state().particles;
  double mass = 0.0, moment = 0.0;
  for (std::size_t a = 0; a < p.size(); ++a) {
    mass += p.mass[a];
    moment += p.mass[a] * p.position[a].y();
  }
  return 2.0 * moment / mass;
}

TEST(Inlet, FillsAChannelAtTheRateGiven) {
  auto scene = tank();
  scene.water_faces[0].discharge = Series{{{0.0, 0.0}, {1.0, 0.02}, {3.0, 0.02}, {4.0, 0.0}}};
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  for (const double end : {1.0, 2.0, 3.0, 4.0, 6.0}) {
    run_to(fluid, time, end);
    const double poured = scene.water_faces[0].discharge->integral(0.0, end);
    EXPECT_NEAR(reading(fluid, "water_stored") / poured, 1.0, 1e-9) << end << " s";
    EXPECT_NEAR(reading(fluid, "through") / poured, 1.0, 1e-9) << end << " s";
    EXPECT_NEAR(reading(fluid, "water_error") / poured, 0.0, 1e-9) << end << " s";
    // The pistons contain less than a row between themselves and the water; all other water is in particles.
    double mass = 0.0;
    for (const double m : fluid.state().particles.mass) mass += m;
    EXPECT_NEAR(1e-3 * mass, poured, 0.5 * dx * 0.2 + 1e-12) << end << " s";
  }
  EXPECT_EQ(fluid.counters().at("lost, far outside"), 0.0);
  EXPECT_NEAR(level(fluid), 0.06 / 0.4, 0.5 * dx);
}

TEST(Inlet, AReservoirFollowsItsHead) {
  auto scene = tank();
  scene.fluid.regions = {box(0.0, 0.0, 0.4, 0.1)};
  scene.water_faces[0].head = Series{{{0.0, 0.1}, {2.0, 0.1}, {12.0, 0.24}, {16.0, 0.24}, {26.0, 0.14}, {30.0, 0.14}}};
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  for (int second = 1; second <= 30; ++second) {
    run_to(fluid, time, second);
    const double wanted = scene.water_faces[0].head->at(second);
    EXPECT_NEAR(level(fluid), wanted, 0.5 * dx) << second << " s";
    EXPECT_NEAR(reading(fluid, "level"), wanted, 0.5 * dx) << second << " s";
    EXPECT_NEAR(reading(fluid, "water_error"), 0.0, 1e-12) << second << " s";
  }
  EXPECT_EQ(fluid.counters().at("lost, far outside"), 0.0);
  EXPECT_GT(fluid.counters().at("deleted"), 0.0);
}

// Water that is drawn off for long is replaced completely; otherwise the level would be lower by the height q / sqrt(g
// d) of a wave that brings the water (13 mm here).
TEST(Inlet, AReservoirThatIsDrawnOnKeepsItsHead) {
  auto scene = tank();
  scene.walls.push_back(wall(line(0.4, 0.0, 1.0, 0.0)));
  scene.walls[2] = wall(line(1.2, 0.0, 1.2, 1.0));
  scene.fluid.regions = {box(0.0, 0.0, 1.2, 0.24)};
  scene.water_faces[0].head = constant(0.24);
  WaterFace drain;
  drain.name = "drain";
  drain.face = line(1.0, 0.0, 1.2, 0.0);
  drain.discharge = Series{{{0.0, 0.0}, {2.0, -0.02}, {40.0, -0.02}}};
  scene.water_faces.push_back(drain);
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  run_to(fluid, time, 15.0);
  double mean = 0.0;
  for (int i = 1; i <= 50; ++i) {
    run_to(fluid, time, 15.0 + 0.2 * i);
    mean += 0.02 * reading(fluid, "level");
  }
  std::printf("level %.4f, supplied %.4f\n", mean, reading(fluid, "through"));
  EXPECT_NEAR(mean, 0.24, 0.1 * dx);
}

TEST(Inlet, AReservoirFillsFromEmpty) {
  auto scene = tank();
  scene.water_faces[0].head = Series{{{0.0, 0.0}, {10.0, 0.15}}};
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  run_to(fluid, time, 12.0);
  EXPECT_NEAR(level(fluid), 0.15, 0.5 * dx);
}

// Without gravity, in a full pipe with an open end, the water moves as the piston does. (Without gravity the water
// would follow a piston that draws back with a delay, since nothing presses it after the piston.)
TEST(Inlet, WaterInAPipeMovesAsOne) {
  Case scene;
  scene.general.gravity.setZero();
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = dx;
  scene.fluid.regions = {box(0.0, 0.0, 0.3, 0.1)};
  scene.walls = {wall(line(0.0, 0.0, 0.8, 0.0)), wall(line(0.8, 0.1, 0.0, 0.1))};
  WaterFace in;
  in.face = line(0.0, 0.1, 0.0, 0.0);
  in.discharge = Series{{{0.0, 0.0}, {0.2, 0.02}, {0.5, 0.02}}};
  scene.water_faces = {in};
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  for (const double end : {0.3, 0.4, 0.5}) {
    run_to(fluid, time, end, 5e-3);
    const auto& velocity = fluid.state().particles.velocity;
    double mean = 0.0;
    for (const auto& v : velocity) {
      mean += v.x() / static_cast<double>(velocity.size());
      EXPECT_NEAR(v.x(), 0.2, 0.01) << end << " s";
      EXPECT_NEAR(v.y(), 0.0, 0.01) << end << " s";
    }
    EXPECT_NEAR(mean, 0.2, 0.002) << end << " s";
  }
}

// Two tanks of equal level with a sill between them; one wall line with two convex corners, and a side made of two
// straight pieces.
TEST(Walls, WaterAtRestAroundCornersThatTurnAway) {
  for (const double jitter : {0.0, 0.2}) {
    Case scene;
    scene.solid.model = SolidCase::Model::rigid;
    scene.fluid.particle_spacing = dx;
    scene.fluid.jitter = jitter;
    scene.fluid.regions = {box(0.0, 0.0, 0.3, 0.1), box(0.5, 0.0, 0.8, 0.1), box(0.0, 0.1, 0.8, 0.3)};
    Face walls;
    for (const auto& [x, y] : std::vector<std::pair<double, double>>{{0.0, 0.5},
                                                                     {0.0, 0.2},
                                                                     {0.0, 0.0},
                                                                     {0.3, 0.0},
                                                                     {0.3, 0.1},
                                                                     {0.5, 0.1},
                                                                     {0.5, 0.0},
                                                                     {0.8, 0.0},
                                                                     {0.8, 0.5}})
      walls.points.push_back({x, y, 0.0});
    scene.walls = {wall(walls)};
    Fluid<2> fluid(scene);
    fluid.initialise({});
    double time = 0.0;
    run_to(fluid, time, 2.0);
    const auto& p = fluid.state().particles;
    double error = 0.0, fastest = 0.0;
    for (std::size_t a = 0; a < p.size(); ++a) {
      error += p.pressure[a] * p.pressure[a] / static_cast<double>(p.size());
      fastest = std::max(fastest, p.velocity[a].norm());
    }
    EXPECT_LT(std::sqrt(error) / (9810.0 * 0.3), jitter == 0.0 ? 1e-6 : 0.03);
    EXPECT_LT(fastest, jitter == 0.0 ? 1e-6 : 0.2);
    EXPECT_EQ(fluid.counters().at("lost, far outside"), 0.0);
    for (const auto& x : p.position) EXPECT_FALSE(x.x() > 0.3 && x.x() < 0.5 && x.y() < 0.1) << x.transpose();
  }
}

// A basin without right angles: water stays at rest within walls of any slope.
TEST(Walls, WaterAtRestInABowl) {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = dx;
  Face walls;
  for (const auto& [x, y] : std::vector<std::pair<double, double>>{
           {-0.2, 0.6}, {0.0, 0.15}, {0.15, 0.0}, {0.4, 0.0}, {0.8, 0.15}, {0.9, 0.6}})
    walls.points.push_back({x, y, 0.0});
  scene.walls = {wall(walls)};
  Shape water;
  water.kind = Shape::Kind::polygon;
  water.points = walls.points;
  water.points.front() = {-0.2 / 0.45 * 0.15, 0.3, 0.0};
  water.points.back() = {0.8 + 0.1 / 0.45 * 0.15, 0.3, 0.0};
  scene.fluid.regions = {water};
  scene.gauges = {gauge("pressure", "point", {}, "pore_pressure"), gauge("kinetic", "kinetic_energy")};
  scene.gauges[0].points = {{0.2, 0.0, 0.0}, {0.6, 0.075, 0.0}, {0.075, 0.075, 0.0}, {0.4, 0.2, 0.0}};
  Fluid<2> fluid(scene);
  fluid.initialise({});
  const auto particles = fluid.state().particles.size();
  double time = 0.0;
  run_to(fluid, time, 10.0);
  const double depth = 0.3;
  for (const auto& [point, y] :
       {std::pair{"pressure[0]", 0.0}, {"pressure[1]", 0.075}, {"pressure[2]", 0.075}, {"pressure[3]", 0.2}}) {
    std::printf("%s: %+.4f of the depth\n", point, reading(fluid, point) / (9810.0 * depth) - (depth - y) / depth);
    EXPECT_NEAR(reading(fluid, point) / (9810.0 * depth), (depth - y) / depth, 0.02);
  }
  std::printf("%.2g J\n", reading(fluid, "kinetic"));
  EXPECT_EQ(fluid.state().particles.size(), particles);
  EXPECT_EQ(fluid.counters().at("lost, far outside"), 0.0);
}

}  // namespace
}  // namespace poretwin::fluid
