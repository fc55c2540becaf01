// Walls thinner than the kernel: nothing interacts through them, also past free tips and corners.
#include "fluid_solver/boundary/walls.hpp"
#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/scenes.hpp"

#include <gtest/gtest.h>

namespace poretwin::fluid {
namespace {

using namespace test;

/// Two tanks side by side, with water 1.2 and 0.4 m deep and a partition between them; thickness 0: a line.
Case two_tanks(double thickness, double spacing) {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = spacing;
  const double there = 0.6 + thickness;
  scene.walls = {wall(line(0.0, 2.0, 0.0, 0.0))};
  if (thickness > 0.0) {
    scene.walls.push_back(
        line_of({{0.0, 0.0}, {0.6, 0.0}, {0.6, 1.5}, {there, 1.5}, {there, 0.0}, {there + 0.6, 0.0}}));
  } else {
    scene.walls.push_back(wall(line(0.0, 0.0, 1.2, 0.0)));
    scene.walls.push_back(wall(line(0.6, 1.5, 0.6, 0.0)));
  }
  scene.walls.push_back(wall(line(there + 0.6, 0.0, there + 0.6, 2.0)));
  scene.fluid.regions = {box(0.0, 0.0, 0.6, 1.2), box(there, 0.0, there + 0.6, 0.4)};
  const double aside = 1e-3 * spacing;  // offset that puts a point on one side of a line
  scene.gauges = {gauge("p", "point",
                        {Point3(0.3, 0.2, 0.0), Point3(0.6 - aside, 0.2, 0.0), Point3(there + 0.3, 0.2, 0.0),
                         Point3(there + aside, 0.2, 0.0)},
                        "pore_pressure"),
                  gauge("speed", "max_speed"), gauge("particles", "particles"),
                  gauge("unexplained", "unexplained_impulse")};
  return scene;
}

/// A tank with a partition that ends under water, 6 spacings above the floor; levels on the left and right.
Case tank_with_a_tip(double thickness, double spacing, double left, double right) {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = spacing;
  const double a = 1.0 - 0.5 * thickness, b = 1.0 + 0.5 * thickness, tip = 6.0 * spacing;
  scene.walls = {line_of({{0.0, 2.0}, {0.0, 0.0}, {2.0, 0.0}, {2.0, 2.0}}),
                 thickness > 0.0 ? line_of({{b, 1.5}, {b, tip}, {a, tip}, {a, 1.5}}) : wall(line(1.0, 1.5, 1.0, tip))};
  scene.fluid.regions = {box(0.0, 0.0, 2.0, tip), box(0.0, tip, a, left), box(b, tip, 2.0, right)};
  scene.gauges = {
      gauge("p", "point", {Point3(0.5, 0.1, 0.0), Point3(1.0, 0.1, 0.0), Point3(1.1, 0.4, 0.0)}, "pore_pressure"),
      gauge("speed", "max_speed"), gauge("particles", "particles"), gauge("energy", "energy")};
  return scene;
}

/// A layer of 2 x 0.6 m on an impermeable base under heads of 0.9 and 0.7 m, with a pile to its middle; thickness 0: a
/// line.
Case layer_with_a_pile(double thickness, double spacing) {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = spacing;
  const double a = 1.0 - 0.5 * thickness, b = 1.0 + 0.5 * thickness;
  Soil soil = sand();
  soil.hydraulic_conductivity = 1e-4;
  soil.shape = box(0.0, 0.0, 2.0, 0.6);
  if (thickness > 0.0) {
    soil.shape.kind = Shape::Kind::polygon;
    soil.shape.points =
        line_of({{0.0, 0.0}, {2.0, 0.0}, {2.0, 0.6}, {b, 0.6}, {b, 0.3}, {a, 0.3}, {a, 0.6}, {0.0, 0.6}}).face.points;
  }
  scene.soils = {soil};
  scene.fluid.regions = {soil.shape};
  scene.walls = {line_of({{0.0, 0.6}, {0.0, 0.0}, {2.0, 0.0}, {2.0, 0.6}}),
                 thickness > 0.0 ? line_of({{b, 0.6}, {b, 0.3}, {a, 0.3}, {a, 0.6}}) : wall(line(1.0, 0.6, 1.0, 0.3))};
  scene.water_faces = {head_face(line(a, 0.6, 0.0, 0.6), 0.9), head_face(line(2.0, 0.6, b, 0.6), 0.7)};
  scene.water_faces[0].name = "up";
  scene.water_faces[1].name = "down";
  scene.gauges = {gauge("in", "passed_volume", {}, "up"), gauge("out", "passed_volume", {}, "down"),
                  gauge("water", "balance"),
                  gauge("head", "point", {Point3(0.9, 0.5, 0.0), Point3(1.1, 0.5, 0.0)}, "head")};
  return scene;
}

/// Around a line with a free tip above a floor, every particle's surroundings are filled exactly once: up to rounding
/// on a lattice that the walls mirror onto itself.
TEST(ThinWalls, SurroundingsAreFilledOnceAroundAFreeTip) {
  Case scene = tank_with_a_tip(0.0, 0.05, 1.0, 1.0);
  scene.walls.push_back(wall(line(2.0, 1.0, 0.0, 1.0)));  // a lid
  scene.walls[1] = wall(line(1.0, 1.0, 1.0, 0.3));
  const auto sight = water_sight<2>(scene, 0.3);
  ASSERT_TRUE(sight.limited());
  const auto lattice = fill<2>(box(0.0, 0.0, 2.0, 1.0), 0.05, Point3(0.5, 0.5, 0.5), 0.0, 1);
  const ScalarArray volume(lattice.position.size(), lattice.volume);
  const auto s = make_stencil<2>(lattice.position, volume, {}, {}, {}, false, worth_threads_in_pairs, sight);
  std::size_t across = 0;
  for (std::size_t a = 0; a < s.n_real; ++a) {
    EXPECT_NEAR(s.fullness[a], 1.0, 1e-9) << s.position[a].transpose();
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k)
      across += s.other[k] < s.n_real && s.position[a].y() > 0.35 &&
                (s.position[s.other[k]].x() < 1.0) != (s.position[a].x() < 1.0) && s.position[s.other[k]].y() > 0.35;
  }
  EXPECT_EQ(across, 0u);
}
TEST(ThinWalls, OfTwoParticlesEachSeesTheOther) {
  for (const double thickness : {0.0, 0.05, 0.1}) {
    const Case scene = tank_with_a_tip(thickness, 0.05, 1.0, 1.0);
    const auto sight = water_sight<2>(scene, 0.3);
    VecArray<2> x;
    ScalarArray volume;
    for (const auto& region : scene.fluid.regions) {
      const auto lattice = fill<2>(region, 0.05, Point3(0.5, 0.5, 0.5), 0.3, 7);
      x.insert(x.end(), lattice.position.begin(), lattice.position.end());
    }
    volume.assign(x.size(), 0.0025);
    const auto s = make_stencil<2>(x, volume, {}, {}, {}, false, worth_threads_in_pairs, sight);
    std::map<std::pair<Index, Index>, double> sum;
    for (std::size_t a = 0; a < s.n_real; ++a)
      for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k)
        if (s.other[k] != a)
          sum[{static_cast<Index>(a), s.parent[s.other[k]]}] += static_cast<double>(s.gradient_factor[k]);
    for (const auto& [pair, factor] : sum) {
      const auto back = sum.find({pair.second, pair.first});
      ASSERT_NE(back, sum.end());
      EXPECT_NEAR(factor, back->second, 1e-5 * std::abs(factor));
    }
  }
}

TEST(ThinWalls, TwoBodiesOfWaterStandBesideEachOther) {
  const double g = 9810.0;
  for (const double spacings : {4.0, 2.0, 1.0, 0.5, 0.0}) {
    SCOPED_TRACE(spacings);
    Fluid<2> water(two_tanks(0.04 * spacings, 0.04));
    water.initialise({});
    const double n = reading(water, "particles");
    double time = 0.0;
    run_to(water, time, 0.5);
    EXPECT_NEAR(reading(water, "p[0]"), g * 1.0, 1e-3 * g * 1.2);
    EXPECT_NEAR(reading(water, "p[1]"), g * 1.0, 1e-3 * g * 1.2);
    EXPECT_NEAR(reading(water, "p[2]"), g * 0.2, 1e-3 * g * 0.4);
    EXPECT_NEAR(reading(water, "p[3]"), g * 0.2, 1e-3 * g * 0.4);
    EXPECT_LT(reading(water, "speed"), 1e-3 * std::sqrt(9.81 * 1.2));
    EXPECT_EQ(reading(water, "particles"), n);
    // Water presses on both sides of a wall.
    const double weight = 0.6 * 1.6 * g;
    EXPECT_NEAR(reading(water, "unexplained_x"), 0.0, 0.01 * weight * 0.5);
    EXPECT_NEAR(reading(water, "unexplained_y"), 0.0, 0.01 * weight * 0.5);
  }
}

/// Compared with finite volumes of the same layer, in the limit of 60, 120 and 240 rows
/// (bench/seepage_under_a_pile.py); piles 4, 2 and 1 spacings thick, and a line.
TEST(ThinWalls, WaterSeepsUnderAPile) {
  struct Pile {
    double thickness, discharge, within;
  };
  for (const auto& [thickness, discharge, within] : {Pile{0.08, 8.4663e-6, 0.015}, Pile{0.04, 9.0619e-6, 0.02},
                                                     Pile{0.02, 9.4238e-6, 0.05}, Pile{0.0, 9.9033e-6, 0.05}}) {
    SCOPED_TRACE(thickness);
    Fluid<2> water(layer_with_a_pile(thickness, 0.02));
    water.initialise({});
    double time = 0.0;
    run_to(water, time, 100.0);
    const double in = reading(water, "in"), out = reading(water, "out");
    run_to(water, time, 400.0);
    const double came = (reading(water, "in") - in) / 300.0, left = -(reading(water, "out") - out) / 300.0;
    std::printf("%g m: in %.4f, out %.4f of finite volumes, heads %.4f, %.4f m\n", thickness, came / discharge,
                left / discharge, reading(water, "head[0]"), reading(water, "head[1]"));
    EXPECT_NEAR(came / discharge, 1.0, within);
    EXPECT_NEAR(left / came, 1.0, 5e-3);
    EXPECT_NEAR(reading(water, "head[0]") + reading(water, "head[1]"), 1.6, 5e-3);  // antisymmetric
    EXPECT_NEAR(reading(water, "water_error"), 0.0, 1e-9);
  }
}

}  // namespace
}  // namespace poretwin::fluid
