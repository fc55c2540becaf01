// Water around edges at which a wall turns away from it: a step, a block, a weir.
#include "common/case/amounts.hpp"
#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/beside_walls.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace poretwin::fluid {
namespace {

using namespace test;

constexpr double g = 9.81, level = 0.8;

using Line = std::vector<std::array<double, 2>>;

/// A tank of 2 m with this floor, whose water reaches up to `level`.
Case over(const Line& floor) {
  Line walls{{0.0, 1.6}}, body{{0.0, level}};
  for (Line* line : {&walls, &body}) line->insert(line->end(), floor.begin(), floor.end());
  walls.push_back({2.0, 1.6});
  body.push_back({2.0, level});
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = dx;
  scene.walls = {line_of(walls)};
  Shape water;
  water.kind = Shape::Kind::polygon;
  for (const auto& [x, y] : body) water.points.push_back(Point3(x, y, 0.0));
  scene.fluid.regions = {water};
  return scene;
}

Line step(double x, double top) { return {{0.0, 0.0}, {x, 0.0}, {x, top}, {2.0, top}}; }
Line block(double left, double right, double top) {
  return {{0.0, 0.0}, {left, 0.0}, {left, top}, {right, top}, {right, 0.0}, {2.0, 0.0}};
}
const Line weir{{0.0, 0.0}, {0.6, 0.0}, {0.8, 0.4}, {1.2, 0.4}, {1.4, 0.0}, {2.0, 0.0}};
Line ramp(double length) { return {{0.0, 0.0}, {1.0 - length, 0.0}, {1.0, 0.4}, {2.0, 0.4}}; }

/// A basin full of water around a block in its middle.
Case ring() {
  Case scene = over({{0.0, 0.0}, {2.0, 0.0}});
  scene.walls = {line_of({{0.0, level}, {0.0, 0.0}, {2.0, 0.0}, {2.0, level}, {0.0, level}}),
                 line_of({{0.8, 0.2}, {0.8, 0.6}, {1.2, 0.6}, {1.2, 0.2}, {0.8, 0.2}})};
  scene.fluid.regions = {box(0.0, 0.0, 2.0, 0.2), box(0.0, 0.2, 0.8, 0.6), box(1.2, 0.2, 2.0, 0.6),
                         box(0.0, 0.6, 2.0, 0.8)};
  return scene;
}

TEST(Edges, OfTwoParticlesEachSeesTheOtherAsOften) {
  std::vector<Case> scenes{ring()};
  for (const auto& floor : {step(1.0, 0.4), step(1.01, 0.413), block(0.8, 1.2, 0.4), block(0.812, 1.223, 0.407),
                            block(0.8, 1.2, 0.08), weir, ramp(0.4), ramp(0.8)})
    scenes.push_back(over(floor));
  for (const Case& scene : scenes) EXPECT_LT(asymmetry(seen(scene, 0.2)), 1e-6);
}

// Of three lattice points around an edge of 90 degrees, two see each other along a line that just meets the edge. Their
// pair and the images behind either side lie on the same places; two of the three points have both.
TEST(Edges, SurroundingsAreFilledOnce) {
  for (const auto& [floor, edges] :
       {std::pair{step(1.0, 0.4), 1}, std::pair{block(0.8, 1.2, 0.4), 2}, std::pair{block(0.8, 1.2, 0.08), 2}}) {
    Case scene = over(floor);
    scene.walls.push_back(line_of({{2.0, level}, {0.0, level}}));
    const auto s = seen(scene, 0.0);
    int short_of_one = 0;
    for (std::size_t a = 0; a < s.n_real; ++a) {
      if (std::abs(s.fullness[a] - 1.0) < 1e-9) continue;
      ++short_of_one;
      EXPECT_NEAR(s.fullness[a], 1.0, 0.045) << s.position[a].transpose();
    }
    EXPECT_LE(short_of_one, edges);
  }
}

TEST(Edges, StillWaterStandsBesideAStepAndABlock) {
  for (const auto& floor : {step(1.0, 0.4), step(1.01, 0.413), block(0.8, 1.2, 0.4), block(0.812, 1.223, 0.407)}) {
    Case scene = over(floor);
    std::vector<Point3> places;
    for (const double x : {0.1, 0.78, 0.83, 0.98, 1.03, 1.18, 1.26, 1.9})
      for (const double y : {0.02, 0.1, 0.38, 0.43, 0.6})
        if (const Point3 place(x, y, 0.0); in_fluid_region(scene, place)) places.push_back(place);
    scene.gauges = {gauge("p", "point", places, "pore_pressure"), gauge("speed", "max_speed")};
    Fluid<2> water(scene);
    water.initialise({});
    double time = 0.0;
    run_to(water, time, 0.5);
    for (std::size_t i = 0; i < places.size(); ++i)
      EXPECT_NEAR(reading(water, "p[" + std::to_string(i) + "]"), 1000.0 * g * (level - places[i].y()),
                  1e-3 * 1000.0 * g * level)
          << places[i].transpose();
    EXPECT_LT(reading(water, "speed"), 1e-3 * std::sqrt(g * level));
  }
}

// Without a surface the matrix is singular, and only a symmetric one has a solution.
TEST(Edges, WaterAroundABlockInAFullBasinIsSolvedFor) {
  Case scene = ring();
  scene.fluid.initial_velocity = {0.4, 0.2, 0.0};
  Fluid<2> water(scene);
  water.initialise({});
  double time = 0.0;
  run_to(water, time, 0.5);
  EXPECT_GT(water.counters().at("pressure iterations"), 100.0);
  EXPECT_EQ(water.counters().at("solves that missed their tolerance"), 0.0);
}

}  // namespace
}  // namespace poretwin::fluid
