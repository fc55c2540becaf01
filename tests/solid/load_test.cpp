// The force of a load on a line is traction times length, however the line runs through the lattice of particles.
#include "common/case/bodies.hpp"
#include "tests/solid/scenes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace poretwin::solid {
namespace {

/// Soil without walls and gravity, under a traction on a line.
Case loaded(std::vector<Point3> soil, std::vector<Point3> line, double spacing) {
  test::ColumnSpec spec;
  spec.base = Wall::ForSoil::none;
  spec.sides = false;
  spec.gravity = 0.0;
  spec.spacing = spacing;
  Case scene = test::column(spec);
  scene.soils[0].shape.kind = Shape::Kind::polygon;
  scene.soils[0].shape.points = std::move(soil);
  scene.solid.initial_rest = false;
  Load load;
  load.name = "load";
  load.face.points = std::move(line);
  load.traction = {300.0, -1000.0, 0.0};
  scene.loads = {load};
  return scene;
}

/// Force on all particles [N].
Vec<2> force_of(const Case& scene) {
  const Solid<2> solid(scene);
  Vec<2> sum = Vec<2>::Zero();
  for (const auto& f : load_forces<2>(solid.setup(), solid.state(), 0.0)) sum += f;
  return sum;
}

double length_of(const std::vector<Point3>& line) {
  double length = 0.0;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) length += (line[i + 1] - line[i]).norm();
  return length;
}

void expect_force(const Case& scene, double length, double tolerance) {
  const Vec<2> right = length * scene.loads[0].traction.head<2>(), found = force_of(scene);
  EXPECT_LT((found - right).norm(), tolerance * right.norm()) << found.transpose() << ", right " << right.transpose();
}

/// Points on a circle about (2, 2) from one angle to another [degrees].
std::vector<Point3> arc(double radius, double from, double to, int pieces) {
  std::vector<Point3> points;
  for (int k = 0; k <= pieces; ++k) {
    const double angle = (from + (to - from) * k / pieces) * std::numbers::pi / 180.0;
    points.emplace_back(2.0 + radius * std::cos(angle), 2.0 + radius * std::sin(angle), 0.0);
  }
  return points;
}

const std::vector<Point3> block{{0, 0, 0}, {4, 0, 0}, {4, 2, 0}, {0, 2, 0}};

TEST(Load, OnALineBetweenColumnsIsTakenAsItIs) {
  const Case scene = loaded(block, {{3, 2, 0}, {1, 2, 0}}, 0.1);
  const Solid<2> solid(scene);
  EXPECT_NEAR(solid.setup().loads.front().scale, 1.0, 1e-12);
  expect_force(scene, 2.0, 1e-12);
}

TEST(Load, OnALineThatEndsWithinAColumnHasTheLengthOfTheLine) {
  expect_force(loaded(block, {{3.03, 2, 0}, {1, 2, 0}}, 0.1), 2.03, 1e-12);
}

// Only the part of a line that lies along soil loads it, also at two spacings from the surface.
TEST(Load, BeyondTheSoilIsNone) { expect_force(loaded(block, {{5, 2.2, 0}, {1.02, 2.2, 0}}, 0.1), 2.98, 1e-3); }

TEST(Load, OnASlopeAndDownToItsToe) {
  const std::vector<Point3> slope{{0, 0, 0}, {4, 0, 0}, {0, 2, 0}};
  for (const double spacing : {0.1, 0.07}) {
    expect_force(loaded(slope, {{3, 0.5, 0}, {1, 1.5, 0}}, spacing), std::sqrt(5.0), 1e-3);
    expect_force(loaded(slope, {{4, 0, 0}, {0, 2, 0}}, spacing), std::sqrt(20.0), 1e-3);
  }
}

// Curves with a radius of 8 to 30 spacings, in few and in many pieces.
TEST(Load, OnACurveIsTractionTimesLength) {
  for (const double spacing : {0.1, 0.05})
    for (const double radius : {0.8, 1.5})
      for (const int pieces : {4, 16, 100}) {
        const auto disc = arc(radius, -180, 180, 2 * pieces), convex = arc(radius, 10, 170, pieces);
        Case scene = loaded({disc.begin(), disc.end() - 1}, convex, spacing);
        expect_force(scene, length_of(convex), 1e-3);
        // A trough in the surface at y = 2.
        std::vector<Point3> trough{{4, 2, 0}, {4, -1, 0}, {0, -1, 0}, {0, 2, 0}};
        const auto bottom = arc(radius, -180, 0, pieces);
        trough.insert(trough.end(), bottom.begin(), bottom.end());
        auto concave = arc(radius, -20, -160, pieces);
        scene = loaded(trough, concave, spacing);
        expect_force(scene, length_of(concave), 1e-3);
        const Solid<2> solid(scene);
        std::printf("radius %g spacings, %d pieces: %.4f\n", radius / spacing, pieces,
                    solid.setup().loads.front().scale);
        EXPECT_NEAR(solid.setup().loads.front().scale, 1.0, 0.1);
      }
}

// All soil around a hole is loaded, wherever its line begins, beyond its corners, too.
TEST(Load, AroundAHoleHasNoSeam) {
  const std::vector<Point3> outside{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}};
  std::vector<Point3> hole{{1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}};  // soil on the left
  std::vector<Point3> soil = outside;
  soil.push_back(outside.front());
  soil.insert(soil.end(), hole.begin(), hole.end());
  soil.push_back(hole.front());
  std::vector<std::vector<Index>> loaded_particles;
  for (int turn = 0; turn < 2; ++turn) {
    std::vector<Point3> line = hole;
    line.push_back(hole.front());
    const Case scene = loaded(soil, line, 0.1);
    expect_force(scene, 8.0, 1e-3);
    const Solid<2> solid(scene);
    auto& all = loaded_particles.emplace_back();
    for (const auto& patch : solid.setup().loads) all.insert(all.end(), patch.particles.begin(), patch.particles.end());
    std::ranges::sort(all);
    std::ranges::rotate(hole, hole.begin() + 2);
  }
  EXPECT_EQ(loaded_particles[0], loaded_particles[1]);
}

// At a loaded face the pore pressure acts on the same particles as the load: undrained, no force is left to move the
// grains.
TEST(Load, IsBalancedByPressureRowByRow) {
  Case scene = loaded(block, {{3.03, 2, 0}, {1, 2, 0}}, 0.1);
  scene.loads[0].traction = {0.0, -1000.0, 0.0};
  WaterFace face;
  face.face.points = scene.loads[0].face.points;
  face.pressure = Series{{{0.0, 0.0}}};
  scene.water_faces = {face};
  Solid<2> solid(scene);
  solid.initialise(test::wet_inbox<2>(solid, [](const Vec<2>&) { return 1000.0; }));
  const auto load = load_forces<2>(solid.setup(), solid.state(), 0.0);
  const auto& patch = solid.setup().loads.front();
  for (const Index i : patch.particles) {
    if (patch.normal.dot(solid.state().particles.position[i]) - patch.level > 0.15) continue;
    const double carried = solid.state().particles.volume[i] * solid.state().external.pressure_gradient[i].y();
    EXPECT_NEAR(load[i].y(), carried, 1e-9 * 1000.0);
  }
}

/// A ball without weight under a pressure on all sides, or one eighth of it between rollers. Its radius is 1 m.
Case pressed_ball(bool eighth) {
  test::ColumnSpec spec;
  spec.dimension = 3;
  spec.base = Wall::ForSoil::none;
  spec.sides = false;
  spec.gravity = 0.0;
  spec.spacing = eighth ? 0.1 : 0.2;
  Case scene = test::column(spec);
  Shape& ball = scene.soils[0].shape;
  ball.kind = Shape::Kind::ball;
  ball.radius = 1.0;
  Shape around;
  around.min = Point3::Constant(-2.0);
  around.max = Point3::Constant(2.0);
  if (eighth) {
    Shape& part = ball.within.emplace_back();
    part.max = Point3::Constant(2.0);
    for (int d = 0; d < 3; ++d) {
      Wall& wall = scene.walls.emplace_back();
      wall.face = test::plane(Point3::Zero(), Point3::Unit(d));
      wall.soil = Wall::ForSoil::roller;
    }
  }
  Load& load = scene.loads.emplace_back();
  load.face.within = around;
  load.pressure = 1000.0;
  make_solids(scene, {});
  return scene;
}

// The forces of a pressure P on all sides do the work P dV in a uniform strain, whatever the surface.
TEST(Load, OnAllSidesDoesTheWorkOfItsPressure) {
  for (const bool eighth : {false, true}) {
    Case scene = pressed_ball(eighth);
    scene.solid.initial_rest = false;
    const Solid<3> solid(scene);
    const auto& p = solid.state().particles;
    const auto force = load_forces<3>(solid.setup(), solid.state(), 0.0);
    double work = 0.0, volume = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      work -= force[i].dot(p.position[i]);
      volume += p.volume[i];
    }
    EXPECT_NEAR(work, 3.0 * 1000.0 * volume, 1e-9 * work);
  }
}

// Hence the stress of elastic soil under it is uniform: minus the pressure.
TEST(Load, OnAllSidesCompressesABallEvenly) {
  Solid<3> solid(pressed_ball(true));
  solid.initialise({});
  const auto& p = solid.state().particles;
  const double bulk = 3e6 / (3.0 * (1.0 - 2.0 * 0.3));
  for (std::size_t i = 0; i < p.size(); ++i) {
    for (int k = 0; k < 6; ++k) EXPECT_NEAR(p.stress[i][k], k < 3 ? -1000.0 : 0.0, 3.0);
    EXPECT_LT((p.displacement[i] + 1000.0 / (3.0 * bulk) * p.position[i]).norm(), 3e-3 * 1000.0 / (3.0 * bulk));
  }
}

}  // namespace
}  // namespace poretwin::solid
