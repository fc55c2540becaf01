// Bodies of water beside each other, between walls of their own: nothing of one of them reaches another.
#include "common/geometry/thin_walls.hpp"
#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/beside_walls.hpp"
#include "tests/fluid/both_solvers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace poretwin::fluid {
namespace {

using namespace test;

constexpr double g = 9.81;

/// A basin with walls of its own and water on its floor.
struct Pond {
  double left, right, floor, depth;  ///< m
  [[nodiscard]] double level() const { return floor + depth; }
};

Case ponds_with(const std::vector<Pond>& ponds, std::vector<Wall> walls) {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = dx;
  scene.walls = std::move(walls);
  for (const auto& pond : ponds) scene.fluid.regions.push_back(box(pond.left, pond.floor, pond.right, pond.level()));
  return scene;
}

/// Ponds whose walls end a metre above their floors.
Case in_basins(const std::vector<Pond>& ponds) {
  std::vector<Wall> walls;
  for (const auto& p : ponds)
    walls.push_back(
        line_of({{p.left, p.floor + 1.0}, {p.left, p.floor}, {p.right, p.floor}, {p.right, p.floor + 1.0}}));
  return ponds_with(ponds, walls);
}

/// Two ponds on either side of a dike; the dike's sides are inclined by `batter` times their height.
Case beside_a_dike(double crest, double batter, double left, double right) {
  constexpr double top = 1.0;
  const double foot = batter * top, a = 0.6 + foot, b = a + crest;
  Case scene = ponds_with({}, {line_of({{0.0, 1.5},
                                        {0.0, 0.0},
                                        {a - foot, 0.0},
                                        {a, top},
                                        {b, top},
                                        {b + foot, 0.0},
                                        {b + foot + 0.6, 0.0},
                                        {b + foot + 0.6, 1.5}})});
  const auto pond = [&](double wall, double foot_of_dike, double depth, double side) {
    Shape shape;
    shape.kind = Shape::Kind::polygon;
    shape.points = {Point3(wall, 0.0, 0.0), Point3(foot_of_dike, 0.0, 0.0),
                    Point3(foot_of_dike + side * batter * depth, depth, 0.0), Point3(wall, depth, 0.0)};
    if (side < 0.0) std::reverse(shape.points.begin(), shape.points.end());
    return shape;
  };
  scene.fluid.regions = {pond(0.0, a - foot, left, 1.0), pond(b + foot + 0.6, b + foot, right, -1.0)};
  return scene;
}

/// Ponds beside each other with this gap between them, on floors at several heights, full to their lids.
std::vector<std::vector<Pond>> neighbours(double gap) {
  const double there = 0.6 + gap;
  std::vector<std::vector<Pond>> scenes;
  for (const double floor : {0.0, 0.04, 0.1, 0.2, 0.4})
    scenes.push_back({{0.0, 0.6, 0.0, 0.8}, {there, there + 0.6, floor, 0.8 - floor}});
  scenes.push_back({{0.0, 0.6, 0.0, 0.8}, {there, there + 0.12, 0.1, 0.6}, {there + 0.12 + gap, 2.0, 0.02, 0.72}});
  return scenes;
}

TEST(Apart, AWallContinuesBeyondACornerForTheImagesOfItsOwnSideOnly) {
  auto planes = water_planes<2>(in_basins({{0.0, 0.6, 0.0, 0.8}}), {}, 0.3);
  const VecArray<2> points{{0.5, 0.1}, {0.65, 0.1}, {-0.05, 0.1}};  // inside, and behind either side
  const auto images = sph::make_images<2>(points, planes, 0.2);
  ASSERT_EQ(images.size(), 3u);  // behind the floor, behind the wall, and behind both
  for (const Index parent : images.parent) EXPECT_EQ(parent, 0u);
  Vec<2> x(0.65, -0.01), v(0.0, -1.0);  // below the floor's level, in another basin
  sph::keep_inside<2>(planes, 0.04, x, v);
  EXPECT_EQ(x, Vec<2>(0.65, -0.01));
  EXPECT_EQ(v, Vec<2>(0.0, -1.0));
  x = Vec<2>(0.61, -0.01);  // has passed both walls at the corner
  v = Vec<2>(1.0, -1.0);
  sph::keep_inside<2>(planes, 0.04, x, v);
  EXPECT_LT((x - Vec<2>(0.59, 0.01)).norm(), 1e-12);
}

TEST(Apart, OfTwoParticlesEachSeesTheOtherAsOften) {
  for (int spacings = 1; spacings <= 12; ++spacings)
    for (const auto& ponds : neighbours(spacings * dx)) {
      SCOPED_TRACE(testing::Message() << spacings << " spacings, floor at " << ponds[1].floor);
      EXPECT_LT(asymmetry(seen(in_basins(ponds), 0.2)), 1e-6);
    }
}

TEST(Apart, TheSurroundingsOfEachAreFilledOnce) {
  for (int spacings = 1; spacings <= 12; ++spacings) {
    SCOPED_TRACE(spacings);
    for (const double floor : {0.0, 0.04, 0.2}) {
      const double there = 0.6 + spacings * dx;
      Case scene = in_basins({{0.0, 0.6, 0.0, 0.8}, {there, there + 0.6, floor, 0.8 - floor}});
      scene.walls.push_back(line_of({{0.6, 0.8}, {0.0, 0.8}}));
      scene.walls.push_back(line_of({{there + 0.6, 0.8}, {there, 0.8}}));
      const auto s = seen(scene, 0.0);
      for (std::size_t a = 0; a < s.n_real; ++a) EXPECT_NEAR(s.fullness[a], 1.0, 1e-9) << s.position[a].transpose();
    }
  }
}

/// Lets the scene stand, and compares pressures and speeds with those of still water in each pond.
void expect_rest(Case scene, const std::vector<std::pair<Point3, double>>& places_and_levels) {
  double deepest = 0.0;
  std::vector<Point3> places;
  for (const auto& [place, level] : places_and_levels) {
    places.push_back(place);
    deepest = std::max(deepest, level - place.y());
  }
  scene.gauges = {gauge("p", "point", places, "pore_pressure"), gauge("speed", "max_speed"),
                  gauge("particles", "particles")};
  Fluid<2> water(scene);
  water.initialise({});
  const double n = reading(water, "particles");
  double time = 0.0;
  run_to(water, time, 0.5);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double depth = places_and_levels[i].second - places[i].y();
    EXPECT_NEAR(reading(water, "p[" + std::to_string(i) + "]"), 1000.0 * g * depth, 1e-3 * 1000.0 * g * deepest)
        << places[i].transpose();
  }
  EXPECT_LT(reading(water, "speed"), 1e-3 * std::sqrt(g * deepest));
  EXPECT_EQ(reading(water, "particles"), n);
  EXPECT_EQ(water.counters().at("solves that missed their tolerance"), 0.0);
}

void expect_rest(const std::vector<Pond>& ponds, Case scene) {
  std::vector<std::pair<Point3, double>> places;
  for (const auto& p : ponds)
    for (const double x : {p.left + 0.1 * dx, 0.5 * (p.left + p.right), p.right - 0.1 * dx})
      places.push_back({Point3(x, p.floor + 0.1, 0.0), p.level()});
  expect_rest(std::move(scene), places);
}

TEST(Apart, TwoBasinsStandBesideEachOther) {
  for (int spacings = 1; spacings <= 10; ++spacings)
    for (const double floor : {0.0, 0.1}) {
      SCOPED_TRACE(testing::Message() << spacings << " spacings, floor at " << floor);
      const double there = 0.6 + spacings * dx;
      const std::vector<Pond> ponds{{0.0, 0.6, 0.0, 0.8}, {there, there + 0.6, floor, 0.4}};
      expect_rest(ponds, in_basins(ponds));
    }
}

TEST(Apart, ThreeBasinsStandBesideEachOther) {
  const std::vector<Pond> ponds{{0.0, 0.4, 0.0, 0.8}, {0.6, 0.8, 0.2, 0.4}, {1.04, 1.4, 0.04, 0.6}};
  expect_rest(ponds, in_basins(ponds));
}

TEST(Apart, ABasinStandsBesideSaturatedSoilThatMoves) {
  Case scene = in_basins({{0.0, 0.6, 0.0, 0.6}, {0.8, 1.4, 0.1, 0.8}});
  scene.general.end_time = 0.1;
  scene.solid.model = SolidCase::Model::elastic;
  scene.solid.particle_spacing = dx;
  scene.soils = {sand()};
  Soil& soil = scene.soils[0];
  soil.shape = box(0.0, 0.0, 0.6, 0.6);
  soil.hydraulic_conductivity = 1e-3;
  soil.grain_density = 2600.0;
  soil.youngs_modulus = 1e6;
  soil.poissons_ratio = 0.3;
  scene.gauges = {gauge("p", "point",
                        {Point3(0.3, 0.2, 0.0), Point3(0.58, 0.2, 0.0), Point3(0.82, 0.2, 0.0), Point3(1.1, 0.2, 0.0)},
                        "pore_pressure")};
  BothSolvers both(scene);
  both.run_to_end();
  for (const char* in_soil : {"p[0]", "p[1]"}) EXPECT_NEAR(reading(both.fluid, in_soil), 3924.0, 1e-3 * 5886.0);
  for (const char* in_basin : {"p[2]", "p[3]"}) EXPECT_NEAR(reading(both.fluid, in_basin), 6867.0, 1e-3 * 7848.0);
}

// The floor of the upper pond ends in the middle of a wall; the lower pond stands on the other side.
TEST(Apart, AFloorThatEndsOnAHigherWallMirrorsNothingBehindIt) {
  for (const int spacings : {5, 6, 8}) {
    SCOPED_TRACE(spacings);
    const double there = 0.6 + spacings * dx;
    const std::vector<Pond> ponds{{0.0, 0.6, 0.4, 0.4}, {there, there + 0.6, 0.0, 0.8}};
    expect_rest(ponds,
                ponds_with(ponds, {line_of({{0.0, 1.4}, {0.0, 0.4}, {0.6, 0.4}}), line_of({{0.6, -0.2}, {0.6, 1.4}}),
                                   line_of({{there, 1.4}, {there, 0.0}, {there + 0.6, 0.0}, {there + 0.6, 1.4}})}));
  }
}

TEST(Apart, TwoPondsStandBesideADike) {
  for (const double crest : {0.04, 0.2, 0.28}) {
    SCOPED_TRACE(testing::Message() << crest << " m");
    const double right = 0.6 + crest;
    expect_rest(beside_a_dike(crest, 0.0, 0.8, 0.4), {{Point3(0.3, 0.2, 0.0), 0.8},
                                                      {Point3(0.6 - 0.1 * dx, 0.2, 0.0), 0.8},
                                                      {Point3(right + 0.1 * dx, 0.2, 0.0), 0.4},
                                                      {Point3(right + 0.3, 0.2, 0.0), 0.4}});
  }
}

TEST(Apart, ADikeWithSteepSlopesIsThinNearItsCrest) {
  for (const double batter : {0.3, 0.5, 0.8}) {
    SCOPED_TRACE(batter);
    EXPECT_TRUE(thin_walls(beside_a_dike(0.24, batter, 0.96, 0.96), Keeps::water).empty());
    const Case scene = beside_a_dike(0.02, batter, 0.96, 0.9);
    ASSERT_FALSE(thin_walls(scene, Keeps::water).empty());
    EXPECT_LT(asymmetry(seen(scene, 0.2)), 1e-6);
  }
}

}  // namespace
}  // namespace poretwin::fluid
