// A reservoir whose level follows from its water balance.
#include "fluid_solver/boundary/basin.hpp"

#include "common/core/error.hpp"
#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/scenes.hpp"

#include <gtest/gtest.h>

namespace poretwin::fluid {
namespace {

using namespace test;

TEST(Basin, LevelInvertsVolume) {
  const Series area{{{0.0, 1.05}, {1.0, 2.55}, {2.0, 2.0}}};
  EXPECT_NEAR(basin_volume(area, 0.4), 1.05 * 0.4 + 0.5 * 1.5 * 0.16, 1e-12);
  for (const double level : {0.0, 0.3, 1.0, 1.4, 2.0, 3.5})
    EXPECT_NEAR(basin_level(area, basin_volume(area, level)), level, 1e-12);
  EXPECT_EQ(basin_level(area, -1.0), 0.0);
}

TEST(Basin, DrainsThroughSoilAtItsClosedForm) {
  // A basin of area A before a confined layer of length L and height a, tailwater at H2: A dH/dt = Q - k a (H - H2)/L.
  const double k = 2e-3, a = 0.1, L = 0.2, A = 0.05, H0 = 0.4, H2 = 0.2, Q = 4e-5;
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = 0.01;
  Soil sand;
  sand.hydraulic_conductivity = k;
  sand.shape = box(0.0, 0.0, L, a);
  scene.soils = {sand};
  scene.fluid.regions = {box(0.0, 0.0, L, a)};
  scene.walls = {wall(line(0.0, 0.0, L, 0.0)), wall(line(L, a, 0.0, a))};
  scene.water_faces = {head_face(line(0.0, a, 0.0, 0.0), H0), head_face(line(L, 0.0, L, a), H2)};
  scene.water_faces[0].discharge = constant(Q);
  scene.water_faces[0].basin_area = Series{{{0.0, A}, {1.0, A}}};
  scene.water_faces[0].name = "basin";
  scene.gauges = {gauge("level", "level", {}, "basin"), gauge("in", "passed_volume", {}, "basin")};
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  const double rate = k * a / (L * A), rest = H2 + Q * L / (k * a);
  for (const double t : {20.0, 50.0, 100.0, 200.0}) {
    run_to(fluid, time, t, 0.2);
    const double exact = rest + (H0 - rest) * std::exp(-rate * t), level = reading(fluid, "level");
    std::printf("t %.0f s: level %.5f m, exact %.5f m\n", t, level, exact);
    EXPECT_NEAR(level, exact, 0.01 * (H0 - H2));
    EXPECT_NEAR(A * (level - H0), Q * t - reading(fluid, "in"), 1e-12);  // the water that it lost passed the face
  }
}

TEST(Basin, StopsWhereItCannotRunOver) {
  // A pond on level ground without banks.
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = 0.01;
  scene.soils = {sand()};
  scene.soils[0].shape = box(0.0, 0.0, 0.2, 0.1);
  scene.walls = {wall(line(0.0, 0.0, 0.2, 0.0))};
  scene.water_faces = {head_face(line(0.2, 0.1, 0.0, 0.1), 0.1)};
  scene.water_faces[0].discharge = constant(1e-3);
  scene.water_faces[0].basin_area = Series{{{0.1, 0.2}, {1.0, 0.2}}};
  scene.water_faces[0].name = "pond";
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  try {
    run_to(fluid, time, 10.0);
    FAIL() << "ran on to " << time << " s";
  } catch (const DivergedError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("water_face[0] \"pond\" has risen to 0.1"), std::string::npos) << text;
    EXPECT_NE(text.find("at 0.1 m, and cannot run over there: the face is level and open at an end"), std::string::npos)
        << text;
  }
}

}  // namespace
}  // namespace poretwin::fluid
