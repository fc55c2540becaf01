// Cavitation: where the pressure would fall below that of vapour, voids open at that pressure.
#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/scenes.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace poretwin::fluid {
namespace {

using namespace test;

/// A tube of soil 12 m high, closed at its top; its foot is in water of the given pressure [Pa].
Case barometer(Series foot) {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = 0.25;
  scene.fluid.regions = {box(0.0, 0.0, 1.0, 12.0)};
  scene.soils = {sand()};
  scene.soils[0].hydraulic_conductivity = 1e-3;
  scene.soils[0].shape = box(0.0, 0.0, 1.0, 12.0);
  scene.walls = {wall(line(0.0, 12.0, 0.0, 0.0)), wall(line(1.0, 0.0, 1.0, 12.0)), wall(line(1.0, 12.0, 0.0, 12.0))};
  scene.water_faces = {pressure_face(line(0.0, 0.0, 1.0, 0.0), 0.0)};
  scene.water_faces[0].pressure = std::move(foot);
  return scene;
}

double voids(const Fluid<2>& fluid) {
  const auto& c = fluid.state().particles.void_volume;
  return std::accumulate(c.begin(), c.end(), 0.0);
}

/// Area of the particles and of the part of the outermost spacing that is inside the face [m2].
double volume(const Fluid<2>& fluid) {
  double sum = 0.0;
  for (const double m : fluid.state().particles.mass) sum += m / 1000.0;
  for (const auto& c : fluid.state().columns) sum += c.share(1000.0);
  return sum;
}

double lowest(const Fluid<2>& fluid) {
  const auto& p = fluid.state().particles;
  double least = HUGE_VAL;
  for (std::size_t a = 0; a < p.size(); ++a)
    least = std::min(least, p.pressure[a] + 9810.0 * (12.0 - p.position[a].y()));
  return least;
}

// Torricelli's barometer: 10.09 m of water hang below the vacuum, not 12. At the first instant the uppermost row of
// particles, z = 11.875 m, cavitates, and Darcy's velocity below it is k (1 - 10.09/z).
TEST(Cavitation, AHangingColumnTearsAtItsTop) {
  Fluid<2> fluid(barometer(constant(0.0)));
  fluid.initialise({});
  fluid.advance({0, 0.0, 1.0}, {});
  const double hangs = 98986.0 / 9810.0, z = 11.875, speed = 1e-3 / 0.4 * (1.0 - hangs / z);
  const auto& p = fluid.state().particles;
  double cavitating = 0.0;
  for (std::size_t a = 0; a < p.size(); ++a) {
    if (p.void_volume[a] > 0.0) {
      cavitating += 1.0;
      EXPECT_GT(p.position[a].y(), z - 0.1);
    }
    const double pressure = p.pressure[a] + 9810.0 * (12.0 - p.position[a].y());
    EXPECT_NEAR(pressure, -98986.0 * p.position[a].y() / z, 200.0) << p.position[a].y();
    if (p.position[a].y() > z - 0.5) continue;
    EXPECT_NEAR(-p.velocity[a].y() / speed, 1.0, 0.01) << p.position[a].y();
  }
  EXPECT_EQ(cavitating, 4.0);
  EXPECT_NEAR(voids(fluid), 0.4 * speed * 1.0, 0.01 * 0.4 * speed);
  EXPECT_EQ(fluid.counters().at("particles that cavitated, most at once"), 4.0);
  EXPECT_EQ(fluid.counters().at("s: first cavitation"), 1.0);
}

// Without a cavitation pressure water sustains any tension, and nothing moves.
TEST(Cavitation, WithoutAFloorItHangs) {
  auto scene = barometer(constant(0.0));
  scene.water.cavitation_pressure = -1e9;
  Fluid<2> fluid(scene);
  fluid.initialise({});
  fluid.advance({0, 0.0, 1.0}, {});
  EXPECT_NEAR(lowest(fluid), -9810.0 * 11.875, 50.0);
  for (const auto& v : fluid.state().particles.velocity) EXPECT_LT(v.norm(), 1e-7);
  EXPECT_EQ(fluid.counters().count("s: first cavitation"), 0u);
}

// Voids close when the foot is put under pressure, and the pressure rises only after that; no water is lost.
TEST(Cavitation, VoidsCloseBeforeThePressureRises) {
  Fluid<2> fluid(barometer(Series{{{0.0, 0.0}, {60.0, 0.0}, {80.0, 4e4}}}));
  fluid.initialise({});
  const double full = volume(fluid);
  double time = 0.0;
  for (const double end : {20.0, 40.0, 60.0, 70.0, 80.0}) {
    run_to(fluid, time, end, 1.0);
    EXPECT_GT(voids(fluid), 0.0);
    std::printf("t %g voids %.6f missing %.6f lowest %.1f\n", time, voids(fluid), full - volume(fluid), lowest(fluid));
    EXPECT_GT(lowest(fluid), -98986.0 - 100.0);
    EXPECT_NEAR(voids(fluid), full - volume(fluid), 0.02 * voids(fluid));
  }
  run_to(fluid, time, 200.0, 1.0);
  std::printf("t %g voids %.6g missing %.6g lowest %.1f\n", time, voids(fluid), full - volume(fluid), lowest(fluid));
  EXPECT_EQ(voids(fluid), 0.0);
  EXPECT_NEAR(full - volume(fluid), 0.0, 1e-4);
  EXPECT_NEAR(lowest(fluid), 4e4 - 9810.0 * 11.875, 500.0);
}

}  // namespace
}  // namespace poretwin::fluid
