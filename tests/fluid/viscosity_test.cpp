// Viscous flow along no-slip and free-slip walls, compared with exact solutions.
#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/scenes.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace poretwin::fluid {
namespace {

using namespace test;

constexpr double pi = std::numbers::pi;

/// A layer of depth `depth` on a floor along x, periodic and driven along x by a force g; no gravity across.
Case layer(double depth, double dx, double viscosity, double g) {
  Case scene;
  scene.general.gravity = Point3(g, 0.0, 0.0);
  scene.general.domain_max = Point3(10.0 * dx, depth, 0.0);
  scene.general.periodic = {0};
  scene.solid.model = SolidCase::Model::rigid;
  scene.water.kinematic_viscosity = viscosity;
  scene.fluid.particle_spacing = dx;
  scene.fluid.regions = {box(0.0, 0.0, 10.0 * dx, depth)};
  scene.walls = {wall(line(0.0, 0.0, 10.0 * dx, 0.0))};
  return scene;
}

Wall lid(double depth, double dx, Wall::ForWater water) {
  Wall result = wall(line(10.0 * dx, depth, 0.0, depth));
  result.water = water;
  return result;
}

/// Velocity of water started from rest between two no-slip walls at distance `width`, at y from one of them; half of
/// that width is a layer with a free-slip other side.
double started(double y, double width, double viscosity, double g, double time) {
  double u = g / (2.0 * viscosity) * y * (width - y);
  for (int m = 1; m < 60; m += 2)
    u -= 4.0 * g * width * width / (viscosity * std::pow(pi * m, 3)) * std::sin(m * pi * y / width) *
         std::exp(-viscosity * std::pow(m * pi / width, 2) * time);
  return u;
}

/// Largest error of any particle, over the largest velocity.
double error(const Fluid<2>& fluid, double width, double viscosity, double g, double time) {
  const auto& p = fluid.state().particles;
  double worst = 0.0;
  for (std::size_t a = 0; a < p.size(); ++a)
    worst = std::max(worst, std::abs(p.velocity[a].x() - started(p.position[a].y(), width, viscosity, g, time)));
  return worst / started(0.5 * width, width, viscosity, g, time);
}

// Plane Poiseuille flow, and half of it under a free-slip lid, during its start and when it is steady.
TEST(Viscosity, FlowBetweenWallsIsPoiseuilles) {
  const double viscosity = 0.1, g = 0.8;
  for (const auto water : {Wall::ForWater::no_slip, Wall::ForWater::free_slip}) {
    const double width = water == Wall::ForWater::no_slip ? 1.0 : 2.0;  // width of the whole profile
    double before = 0.0;
    for (const double dx : {0.1, 0.05, 0.025}) {
      Case scene = layer(1.0, dx, viscosity, g);
      scene.walls[0].water = Wall::ForWater::no_slip;
      scene.walls.push_back(lid(1.0, dx, water));
      Fluid<2> fluid(scene);
      fluid.initialise({});
      double time = 0.0, worst = 0.0;
      for (const double end : {0.5, 1.0, 4.0}) {
        run_to(fluid, time, end);
        const double now = error(fluid, width, viscosity, g, time);
        std::printf("width %g, spacing %g, %g s: %.4f\n", width, dx, time, now);
        worst = std::max(worst, now);
      }
      if (before > 0.0) {
        EXPECT_LT(worst, 0.6 * before) << dx;
      }
      before = worst;
    }
    EXPECT_LT(before, 0.01);
  }
}

// A film 0.1 m deep that runs down a slope, with a no-slip floor and air above.
TEST(Viscosity, AFilmRunsDownASlopeAsNusselts) {
  const double depth = 0.1, viscosity = 0.01, slope = 0.1;
  double before = 0.0;
  for (const double dx : {0.01, 0.005}) {
    Case scene = layer(depth, dx, viscosity, 0.0);
    scene.general.gravity = Point3(9.81 * slope, -9.81 * std::sqrt(1.0 - slope * slope), 0.0);
    scene.walls[0].water = Wall::ForWater::no_slip;
    Fluid<2> fluid(scene);
    fluid.initialise({});
    double time = 0.0, worst = 0.0;
    for (const double end : {0.2, 1.0}) {
      run_to(fluid, time, end);
      const double now = error(fluid, 2.0 * depth, viscosity, 9.81 * slope, time);
      std::printf("film, spacing %g, %g s: %.4f\n", dx, time, now);
      worst = std::max(worst, now);
    }
    if (before > 0.0) {
      EXPECT_LT(worst, 0.6 * before);
    }
    before = worst;
  }
  EXPECT_LT(before, 0.02);
}

// Along free-slip walls water falls freely.
TEST(Viscosity, WallsWithoutFrictionHoldNothing) {
  Case scene = layer(1.0, 0.05, 0.1, 0.8);
  scene.walls.push_back(lid(1.0, 0.05, Wall::ForWater::free_slip));
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  run_to(fluid, time, 2.0);
  for (const auto& v : fluid.state().particles.velocity) EXPECT_NEAR((v - Vec<2>(1.6, 0.0)).norm(), 0.0, 1e-9);
}

// Gauges beside a no-slip wall: zero velocity on it, and the discharge.
TEST(Viscosity, GaugesSeeThatWaterSticks) {
  const double dx = 0.05, viscosity = 0.1, g = 0.8;
  Case scene = layer(1.0, dx, viscosity, g);
  scene.walls[0].water = Wall::ForWater::no_slip;
  scene.walls.push_back(lid(1.0, dx, Wall::ForWater::no_slip));
  Gauge velocity, discharge;
  velocity.name = discharge.name = "velocity";
  velocity.phase = discharge.phase = "fluid";
  velocity.kind = "point";
  velocity.quantity = "velocity_x";
  velocity.points = {Point3(0.1, 0.0, 0.0)};
  discharge.name = discharge.kind = "discharge";
  discharge.points = {Point3(0.1, 1.0, 0.0), Point3(0.1, 0.0, 0.0)};
  scene.gauges = {velocity, discharge};
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  run_to(fluid, time, 6.0);
  const double mean = g / (12.0 * viscosity);
  EXPECT_NEAR(reading(fluid, "velocity") / mean, 0.0, 0.02);
  EXPECT_NEAR(reading(fluid, "discharge") / mean, 1.0, 0.02);
}

}  // namespace
}  // namespace poretwin::fluid
