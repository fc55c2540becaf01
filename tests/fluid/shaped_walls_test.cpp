// Water beside walls of any shape: at rest in containers and around obstacles, thrown against them, along them.
#include "tests/fluid/scenes.hpp"

#include "common/case/bodies.hpp"
#include "fluid_solver/fluid_phase.hpp"
#include "solid_solver/phase.hpp"
#include "tests/coupling/coupled_run.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <map>
#include <numbers>

namespace poretwin::fluid {
namespace {

using namespace test;

constexpr double g = 9.81;

Shape block(const Point3& min, const Point3& max) {
  Shape shape;
  shape.min = min;
  shape.max = max;
  return shape;
}

Wall wall_of(const Shape& shape, Wall::Domain domain) {
  Wall result;
  result.shape = shape;
  result.domain = domain;
  return result;
}

Wall plane(const Point3& point, const Point3& normal) {
  Wall result;
  result.face.point = point;
  result.face.normal = normal;
  return result;
}

/// Water in a region beside walls.
Case tank(std::vector<Wall> walls, const Shape& region, double spacing) {
  Case scene;
  scene.general.dimension = 3;
  scene.general.gravity = Point3(0.0, 0.0, -g);
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = spacing;
  scene.walls = std::move(walls);
  scene.fluid.regions = {region};
  make_solids(scene, {});
  return scene;
}

/// Runs in windows as long as the water proposes or a little shorter: a short last one would tell the noise of its own
/// pressures.
void run(Fluid<3>& fluid, double end) {
  fluid.initialise({});
  double time = 0.0;
  for (std::uint64_t step = 0; end - time > 1e-9; ++step) {
    const double left = end - time, dt = left / std::ceil(left / fluid.publish().proposed_interval);
    fluid.advance({step, time, dt}, {});
    time += dt;
  }
}

/// Elevation from which piezometric pressures count [m]: half a spacing above the highest particle at first.
double origin_of(const Fluid<3>& fluid, double spacing) {
  double top = -HUGE_VAL;
  for (const auto& x : fluid.state().particles.position) top = std::max(top, x.z());
  return top + 0.5 * spacing;
}

/// Of water at rest, below the first row: how far the level that its pressures tell is off, in spacings; the greatest
/// departure of a pressure from that of the level found, over that of the depth; the mean speed over sqrt(g depth).
struct Rest {
  double level = 0.0, pressure = 0.0, speed = 0.0;
};
Rest rest_of(const Fluid<3>& fluid, double origin, double level, double depth, double spacing) {
  const auto& p = fluid.state().particles;
  Rest rest;
  std::vector<double> levels;
  double mean = 0.0;
  for (std::size_t a = 0; a < p.size(); ++a) {
    rest.speed += p.velocity[a].norm() / std::sqrt(g * depth) / static_cast<double>(p.size());
    if (level - p.position[a].z() < 1.5 * spacing) continue;
    levels.push_back(p.pressure[a] / (1000.0 * g) + origin);
    mean += levels.back();
  }
  mean /= static_cast<double>(levels.size());
  rest.level = (mean - level) / spacing;
  for (const double z : levels) rest.pressure = std::max(rest.pressure, std::abs(z - mean) / depth);
  return rest;
}

struct Vessel {
  Shape shape;
  double level, depth;
};

/// A turned box, a cylinder and a ball, and how high water stands in them.
std::map<std::string, Vessel> vessels() {
  Shape box = block(Point3::Constant(-0.25), Point3(0.25, 0.25, 0.9));
  box.placement = Placement{1.0, 40.0, Point3(1.0, 2.0, 0.5), Point3::Zero()};
  Shape cylinder;
  cylinder.kind = Shape::Kind::cylinder;
  cylinder.ends = {Point3::Zero(), Point3(0.0, 0.0, 1.0)};
  cylinder.radius = 0.25;
  Shape ball;
  ball.kind = Shape::Kind::ball;
  ball.centre = Point3(0.0, 0.0, 0.3);
  ball.radius = 0.3;
  return {{"turned box", {box, 0.2, 0.6}}, {"cylinder", {cylinder, 0.4, 0.4}}, {"ball", {ball, 0.35, 0.35}}};
}

TEST(ShapedWalls, HoldWaterAtRest) {
  constexpr double dx = 0.05;
  for (const auto& [name, vessel] : vessels()) {
    Shape region = vessel.shape;
    region.within = {block(Point3::Constant(-2.0), Point3(2.0, 2.0, vessel.level))};
    Fluid<3> fluid(tank({wall_of(vessel.shape, Wall::Domain::inside)}, region, dx));
    const std::size_t before = fluid.state().particles.size();
    const double origin = origin_of(fluid, dx);
    run(fluid, 0.3);
    EXPECT_EQ(fluid.state().particles.size(), before) << name;
    const Rest rest = rest_of(fluid, origin, vessel.level, vessel.depth, dx);
    EXPECT_LT(std::abs(rest.level), 0.05) << name;
    EXPECT_LT(rest.pressure, 0.0025) << name;
    EXPECT_LT(rest.speed, 0.0025) << name;
  }
}

TEST(ShapedWalls, AnObstacleAtRestIsNoSource) {
  constexpr double dx = 0.05;
  const Shape obstacle = block(Point3(0.2, 0.2, 0.0), Point3(0.4, 0.4, 0.2));
  Shape region = block(Point3::Zero(), Point3(0.6, 0.6, 0.4));
  region.without = {block(Point3(0.2, 0.2, -0.1), Point3(0.4, 0.4, 0.2))};
  Fluid<3> fluid(
      tank({plane({0, 0, 0}, {1, 0, 0}), plane({0.6, 0, 0}, {-1, 0, 0}), plane({0, 0, 0}, {0, 1, 0}),
            plane({0, 0.6, 0}, {0, -1, 0}), plane({0, 0, 0}, {0, 0, 1}), wall_of(obstacle, Wall::Domain::outside)},
           region, dx));
  ASSERT_EQ(fluid.state().particles.size(), 12u * 12u * 8u - 4u * 4u * 4u);
  const double origin = origin_of(fluid, dx);
  run(fluid, 0.3);
  const Rest rest = rest_of(fluid, origin, 0.4, 0.4, dx);
  EXPECT_LT(std::abs(rest.level), 0.01);
  EXPECT_LT(rest.pressure, 0.0005);
  EXPECT_LT(rest.speed, 2e-4);
}

// Places on walls, in a corner and on the side and the top of an obstacle, see the images behind them.
TEST(ShapedWalls, AGaugeOnThemReadsAsOneInTheWater) {
  constexpr double dx = 0.05, level = 0.4;
  const Shape obstacle = block(Point3(0.2, 0.2, 0.0), Point3(0.4, 0.4, 0.2));
  Shape region = block(Point3::Zero(), Point3(0.6, 0.6, level));
  region.without = {block(Point3(0.2, 0.2, -0.1), Point3(0.4, 0.4, 0.2))};
  Case scene =
      tank({plane({0, 0, 0}, {1, 0, 0}), plane({0.6, 0, 0}, {-1, 0, 0}), plane({0, 0, 0}, {0, 1, 0}),
            plane({0, 0.6, 0}, {0, -1, 0}), plane({0, 0, 0}, {0, 0, 1}), wall_of(obstacle, Wall::Domain::outside)},
           region, dx);
  const std::vector<Point3> feet{{0.1, 0.1, 0.0}, {0.0, 0.3, 0.0}, {0.6, 0.6, 0.0}, {0.2, 0.3, 0.0}, {0.3, 0.3, 0.2}};
  for (std::size_t k = 0; k < feet.size(); ++k)
    scene.gauges.push_back(gauge(std::to_string(k), "front", {feet[k], Point3(feet[k].x(), feet[k].y(), 1.0)}));
  Fluid<3> fluid(scene);
  run(fluid, 0.05);
  for (std::size_t k = 0; k < feet.size(); ++k)
    EXPECT_NEAR(reading(fluid, std::to_string(k)), level - feet[k].z(), 0.2 * dx) << feet[k].transpose();
}

/// A column of water that collapses in a box of one metre by 0.4; the box's walls are planes or the surface of a shape.
Case collapse(bool planes, double turn) {
  const Shape box = block(Point3::Zero(), Point3(1.0, 0.4, 0.6));
  Shape vessel = box, water = block(Point3::Zero(), Point3(0.4, 0.4, 0.4));
  if (turn != 0.0)
    for (Shape* shape : {&vessel, &water}) shape->placement = Placement{1.0, turn, Point3::UnitZ(), Point3::Zero()};
  if (planes)
    return tank({plane({0, 0, 0}, {1, 0, 0}), plane({1, 0, 0}, {-1, 0, 0}), plane({0, 0, 0}, {0, 1, 0}),
                 plane({0, 0.4, 0}, {0, -1, 0}), plane({0, 0, 0}, {0, 0, 1})},
                water, 0.05);
  return tank({wall_of(vessel, Wall::Domain::inside)}, water, 0.05);
}

double kinetic_energy(const Fluid<3>& fluid) {
  const auto& p = fluid.state().particles;
  double sum = 0.0;
  for (std::size_t a = 0; a < p.size(); ++a) sum += 0.5 * p.mass[a] * p.velocity[a].squaredNorm();
  return sum;
}

TEST(ShapedWalls, AreThePlanesThatTheyCoverAtAnyAngle) {
  std::vector<double> energy;
  for (const auto& [planes, turn] : {std::pair{true, 0.0}, {false, 0.0}, {false, 30.0}}) {
    Fluid<3> fluid(collapse(planes, turn));
    run(fluid, 0.15);
    energy.push_back(kinetic_energy(fluid));
  }
  EXPECT_NEAR(energy[1] / energy[0], 1.0, 1e-9);
  EXPECT_NEAR(energy[2] / energy[0], 1.0, 5e-4);
}

TEST(ShapedWalls, NothingPassesThemAtAnySpeed) {
  for (const double speed : {5.0, 500.0}) {
    Shape ball;
    ball.kind = Shape::Kind::ball;
    ball.radius = 0.3;
    Case scene =
        tank({wall_of(ball, Wall::Domain::inside)}, block(Point3::Constant(-0.1), Point3::Constant(0.1)), 0.05);
    scene.fluid.initial_velocity = Point3(speed, 0.3 * speed, -0.2 * speed);
    Fluid<3> fluid(scene);
    fluid.initialise({});
    for (std::uint64_t step = 0; step < 10; ++step) fluid.advance({step, 0.01 * static_cast<double>(step), 0.01}, {});
    EXPECT_EQ(fluid.state().particles.size(), 64u) << speed;
    for (const auto& x : fluid.state().particles.position) EXPECT_LT(x.norm(), 0.305) << speed;
  }
}

TEST(ShapedWalls, HoldOrLetSlipWaterThatRunsAlongThem) {
  // A plug in a pipe, without gravity: slip leaves it its speed along the axis; no slip slows it, by the closed form
  // for a fluid that starts moving as a whole, sum 4 / j^2 exp(-j^2 nu t / R^2) over the zeros j of Bessel's J0.
  constexpr double radius = 0.3, viscosity = 0.01, end = 0.2;
  double exact = 0.0;
  for (const double j : {2.404826, 5.520078, 8.653728, 11.791534, 14.930918})
    exact += 4.0 / (j * j) * std::exp(-j * j * viscosity * end / (radius * radius));
  std::map<Wall::ForWater, double> left;
  for (const auto kind : {Wall::ForWater::free_slip, Wall::ForWater::no_slip}) {
    Shape cylinder;
    cylinder.kind = Shape::Kind::cylinder;
    cylinder.ends = {Point3(0, 0, -2), Point3(0, 0, 2)};
    cylinder.radius = radius;
    Shape water = cylinder;
    water.ends = {Point3(0, 0, -0.2), Point3(0, 0, 0.2)};
    Wall wall = wall_of(cylinder, Wall::Domain::inside);
    wall.water = kind;
    Case scene = tank({wall}, water, 0.05);
    scene.general.gravity = Point3::Zero();
    scene.water.kinematic_viscosity = viscosity;
    scene.fluid.initial_velocity = Point3(0, 0, 1);
    Fluid<3> fluid(scene);
    run(fluid, end);
    double sum = 0.0;
    for (const auto& v : fluid.state().particles.velocity) sum += v.z();
    left[kind] = sum / static_cast<double>(fluid.state().particles.size());
  }
  EXPECT_NEAR(left[Wall::ForWater::free_slip], 1.0, 0.002);
  EXPECT_NEAR(left[Wall::ForWater::no_slip], exact, 0.1 * exact);
}

TEST(ShapedWalls, HoldSaturatedSoilAtRest) {
  // A turned box with gravity across its bottom: soil and water lie on rows, and nothing may move.
  constexpr double dx = 0.05, turn = 25.0, soil_height = 0.4, water_height = 0.6;
  const Point3 axis(1.0, 2.0, 0.5), shift(0.3, -0.2, 0.1);
  const auto turned = [&](const Point3& max) {
    Shape shape = block(Point3::Zero(), max);
    shape.placement = Placement{1.0, turn, axis, shift};
    return shape;
  };
  const Mat<3> turning = Eigen::AngleAxisd(turn * std::numbers::pi / 180.0, axis.normalized()).toRotationMatrix();
  Case scene =
      tank({wall_of(turned(Point3(0.3, 0.3, 1.0)), Wall::Domain::inside)}, turned(Point3(0.3, 0.3, water_height)), dx);
  scene.general.gravity = turning * Point3(0.0, 0.0, -g);
  scene.general.end_time = 0.05;
  scene.solid.model = SolidCase::Model::elastic;
  scene.solid.particle_spacing = dx;
  Soil soil;
  soil.shape = turned(Point3(0.3, 0.3, soil_height));
  soil.porosity = 0.4;
  soil.grain_density = 2600.0;
  soil.youngs_modulus = 3e6;
  soil.poissons_ratio = 0.3;
  soil.hydraulic_conductivity = 1e-3;
  scene.soils = {soil};
  make_solids(scene, {});
  Fluid<3> fluid(scene);
  solid::Solid<3> skeleton(scene);
  coupling::CoupledRun run;
  run.dimension = 3;
  run.broker.case_digest = scene.digest();
  run.settings = {scene.general.end_time, std::nullopt, 0.0, 0.0};
  run.run(&fluid, &skeleton);
  run.expect_success();
  const auto height = [&](const Point3& x) { return (turning.transpose() * (x - shift)).z(); };
  const auto& water = fluid.state().particles;
  for (std::size_t a = 0; a < water.size(); ++a) {
    EXPECT_NEAR(water.pressure[a], 0.0, 1e-3 * 1000.0 * g * water_height);  // piezometric, from the free surface
    EXPECT_LT(water.velocity[a].norm(), 1e-5);
  }
  const auto& grains = skeleton.state().particles;
  const double weight = 0.6 * 1600.0 * g;  // buoyant, N/m3
  for (std::size_t i = 0; i < grains.size(); ++i) {
    const Point3 up = turning.col(2);
    if (soil_height - height(grains.position[i]) < 3.0 * dx) continue;  // rows below the surface alternate by 3 %
    const double vertical = up.dot(solid::matrix_of<3>(grains.stress[i]) * up),
                 exact = -weight * (soil_height - height(Point3(grains.position[i] - grains.displacement[i])));
    EXPECT_NEAR(vertical, exact, 0.01 * weight * soil_height);
  }
}

}  // namespace
}  // namespace poretwin::fluid
