// Soil on both sides of walls through which a kernel reaches: each side rests as if it were alone.
#include "tests/solid/scenes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>

namespace poretwin::solid {
namespace {

constexpr double dx = 0.05, weight = 0.6 * 2600.0 * 9.81, ratio = 0.3;

Wall roller(const std::vector<std::array<double, 2>>& points) {
  Wall wall;
  for (const auto& [x, y] : points) wall.face.points.push_back(Point3(x, y, 0.0));
  wall.soil = Wall::ForSoil::roller;
  return wall;
}

Soil box(double from, double to, double height) {
  Soil soil = test::column({}).soils[0];
  soil.shape.min = Point3(from, 0.0, 0.0);
  soil.shape.max = Point3(to, height, 0.0);
  return soil;
}

/// A bin of 1 m with soil on both sides of a partition in its middle. thickness: 0 for a line, whose lower end is `tip`
/// above the floor.
Case bin(double thickness, double tip, double left, double right) {
  Case scene = test::column({.spacing = dx});
  const double a = 0.5 - 0.5 * thickness, b = 0.5 + 0.5 * thickness;
  scene.walls = {roller({{0.0, 1.0}, {0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}})};
  if (thickness == 0.0)
    scene.walls.push_back(roller({{0.5, 1.0}, {0.5, tip}}));
  else
    scene.walls.push_back(roller({{a, 0.0}, {a, 1.0}, {b, 1.0}, {b, 0.0}}));
  scene.soils = {box(0.0, a, left), box(b, 1.0, right)};
  return scene;
}

/// The largest error of the stresses of elastic soil at rest, over the weight of the higher side. Each particle lies
/// under the height of its side.
double error_at_rest(const Solid<2>& solid, double left, double right) {
  const auto& p = solid.state().particles;
  double worst = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vec<2> x = p.position[i] - p.displacement[i];
    const double vertical = -weight * ((x.x() < 0.5 ? left : right) - x.y());
    const double horizontal = ratio / (1.0 - ratio) * vertical;
    worst = std::max({worst, std::abs(p.stress[i][0] - horizontal), std::abs(p.stress[i][1] - vertical)});
  }
  return worst / (weight * std::max(left, right));
}

TEST(ThinWallInSoil, KeepsTwoSidesApartWhateverItsThickness) {
  for (const double thickness : {0.0, dx, 2.0 * dx, 4.0 * dx}) {
    Case scene = bin(thickness, 0.0, 0.8, 0.4);
    scene.gauges = {test::point_gauge<2>("left", "effective_stress_xx", {Point3(0.495 - 0.5 * thickness, 0.2, 0.0)}),
                    test::point_gauge<2>("right", "effective_stress_xx", {Point3(0.505 + 0.5 * thickness, 0.2, 0.0)})};
    Gauge level;
    level.name = "level";
    level.phase = "solid";
    level.kind = "height";
    level.points = {Point3(0.48 - 0.5 * thickness, 0.0, 0.0), Point3(0.52 + 0.5 * thickness, 0.0, 0.0)};
    scene.gauges.push_back(level);
    Solid<2> solid(scene);
    solid.initialise({});
    test::run_dry(solid, 0.2, 0.02);
    const double error = error_at_rest(solid, 0.8, 0.4);
    std::printf("thickness %g: stresses %.4f of the weight off\n", thickness, error);
    EXPECT_LT(error, 0.02);
    const double k0 = ratio / (1.0 - ratio) * weight;
    std::map<std::string, double> read;
    for (const auto& reading : solid.gauges()) read[reading.gauge] = reading.value;
    EXPECT_NEAR(read.at("left"), -k0 * 0.6, 0.02 * k0 * 0.8);
    EXPECT_NEAR(read.at("right"), -k0 * 0.2, 0.02 * k0 * 0.8);
    EXPECT_NEAR(read.at("level[0]"), 0.8, 0.2 * dx);
    EXPECT_NEAR(read.at("level[1]"), 0.4, 0.2 * dx);
  }
}

// A smooth sheet pile in level ground changes nothing: neither along it nor at its tip.
TEST(ThinWallInSoil, ASheetPileInLevelGroundLeavesItsStress) {
  Solid<2> solid(bin(0.0, 0.3, 0.6, 0.6));
  solid.initialise({});
  test::run_dry(solid, 0.2, 0.02);
  const double error = error_at_rest(solid, 0.6, 0.6);
  std::printf("stresses %.4f of the weight off\n", error);
  EXPECT_LT(error, 0.02);
}

// Two bins with walls of their own, on floors at different heights. A wall continues behind a corner for the images of
// its own soil only.
TEST(ThinWallInSoil, TwoBinsStandBesideEachOther) {
  for (const double gap : {5.0 * dx, 6.0 * dx}) {
    Case scene = test::column({.spacing = dx});
    const double there = 0.5 + gap, floor = 0.1;
    scene.walls = {roller({{0.0, 1.0}, {0.0, 0.0}, {0.5, 0.0}, {0.5, 1.0}}),
                   roller({{there, 1.0}, {there, floor}, {there + 0.5, floor}, {there + 0.5, 1.0}})};
    scene.soils = {box(0.0, 0.5, 0.8), box(there, there + 0.5, 0.6)};
    scene.soils[1].shape.min.y() = floor;
    Solid<2> solid(scene);
    solid.initialise({});
    test::run_dry(solid, 0.2, 0.02);
    const auto& p = solid.state().particles;
    double worst = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      const Vec<2> x = p.position[i] - p.displacement[i];
      const double vertical = -weight * ((x.x() < 0.55 ? 0.8 : 0.6) - x.y());
      worst = std::max(
          {worst, std::abs(p.stress[i][0] - ratio / (1.0 - ratio) * vertical), std::abs(p.stress[i][1] - vertical)});
    }
    std::printf("gap %g: stresses %.4f of the weight off\n", gap, worst / (0.8 * weight));
    EXPECT_LT(worst, 0.02 * 0.8 * weight);
  }
}

// Sand that slumps against a partition one spacing thick stays on its side of it.
TEST(ThinWallInSoil, NothingPassesIt) {
  Case scene = bin(dx, 0.0, 0.4, 0.2);
  scene.soils[0].shape.min.x() = 0.075;
  scene.soils[0].shape.max.x() = 0.375;
  scene.solid.model = SolidCase::Model::drucker_prager;
  for (Soil& soil : scene.soils) {
    soil.cohesion = 0.0;
    soil.friction_angle = 20.0;
  }
  scene.solid.initial_rest = false;
  Solid<2> solid(scene);
  const auto left = [&] {
    const auto& x = solid.state().particles.position;
    return std::count_if(x.begin(), x.end(), [](const Vec<2>& at) { return at.x() < 0.5; });
  };
  const auto before = left();
  solid.initialise({});
  test::run_dry(solid, 0.6, 0.02);
  EXPECT_EQ(left(), before);
  double nearest = 1.0;
  for (const Vec<2>& x : solid.state().particles.position) {
    EXPECT_GT(std::abs(x.x() - 0.5), 0.5 * dx);
    nearest = std::min(nearest, std::abs(x.x() - 0.5));
  }
  EXPECT_LT(nearest, 1.5 * dx);
  double furthest = 0.0;
  for (const Vec<2>& x : solid.state().particles.position)
    if (x.x() < 0.5) furthest = std::max(furthest, x.x());
  EXPECT_GT(furthest, 0.4);  // it did slump
}

}  // namespace
}  // namespace poretwin::solid
