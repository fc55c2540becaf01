// Between the still water behind a face, in no particles, and real water: over a crest and back.
#include "common/core/error.hpp"
#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/scenes.hpp"

#include <gtest/gtest.h>

namespace poretwin::fluid {
namespace {

using namespace test;

constexpr double dx = 0.01, g = 9.81;

Gauge gauge(const std::string& name, const std::string& kind, const std::string& quantity = {}) {
  Gauge result;
  result.name = name;
  result.phase = "fluid";
  result.kind = kind;
  result.quantity = quantity;
  return result;
}

/// A rigid sill, its crest at 0.1 m, on 0.05 m of nearly tight wet soil, between a basin on its left and tailwater at
/// 0.02 m on its right.
Case sill(double length, double area, double level, double inflow) {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = dx;
  scene.soils = {sand()};
  scene.soils[0].hydraulic_conductivity = 1e-9;
  scene.soils[0].shape = box(0.0, 0.0, length, 0.05);
  scene.fluid.regions = {scene.soils[0].shape};
  scene.walls = {wall(line(0.0, 0.0, length, 0.0)), wall(line(length, 0.05, 0.0, 0.05)),
                 wall(line(0.0, 0.1, length, 0.1)), wall(line(length, 0.1, length, 0.05))};
  scene.water_faces = {head_face(line(0.0, 0.1, 0.0, 0.0), level), head_face(line(length, 0.0, length, 0.05), 0.02)};
  scene.water_faces[0].name = "basin";
  scene.water_faces[0].discharge = constant(inflow);
  scene.water_faces[0].basin_area = Series{{{0.0, area}, {1.0, area}}};
  scene.water_faces[1].name = "tailwater";
  scene.gauges = {gauge("level", "level", "basin"), gauge("through", "passed_volume", "basin"),
                  gauge("tail", "passed_volume", "tailwater"), gauge("water", "balance")};
  return scene;
}

TEST(Passage, OverASillTheDischargeIsCritical) {
  for (const double H : {0.03, 0.06, 0.09}) {
    const double q = std::pow(2.0 / 3.0, 1.5) * std::sqrt(g) * std::pow(H, 1.5), area = 0.3, start = 0.09;
    Fluid<2> fluid(sill(0.6, area, start, q));
    fluid.initialise({});
    double time = 0.0;
    for (double end = 1.0; end <= 10.0; end += 1.0) {
      run_to(fluid, time, end);
      const double level = reading(fluid, "level");
      std::printf("H %.3f t %.1f: head over the crest %.5f m, particles %zu, tail %.6g of %.6g, error %.2e, lost %g\n", H, end,
                  level - 0.1, fluid.state().particles.size(), reading(fluid, "tail"), q * time,
                  reading(fluid, "water_error"), fluid.counters().at("lost, far outside"));
      EXPECT_NEAR(area * (level - start), q * time - reading(fluid, "through"), 1e-12);
      EXPECT_NEAR(reading(fluid, "water_error"), 0.0, 1e-12);
    }
    EXPECT_NEAR(reading(fluid, "level") - 0.1, H, 0.05 * H);
  }
}

TEST(Passage, WaterThatFallsIntoABasinRaisesItByItsVolume) {
  auto scene = sill(0.2, 0.5, 0.05, 0.0);
  scene.fluid.regions.push_back(box(-0.2, 0.15, -0.1, 0.25));
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  run_to(fluid, time, 0.1);
  EXPECT_NEAR(reading(fluid, "level"), 0.05, 1e-3);  // 0.1 m above it still, it has fallen by 0.05 m
  run_to(fluid, time, 1.0);
  std::printf("level %.8f m\n", reading(fluid, "level"));
  EXPECT_NEAR(0.5 * (reading(fluid, "level") - 0.05), -reading(fluid, "through"), 1e-12);
  EXPECT_NEAR(reading(fluid, "level"), 0.05 + 0.01 / 0.5, 1e-5);
  EXPECT_NEAR(reading(fluid, "water_out"), 0.01, 1e-6);
  EXPECT_NEAR(reading(fluid, "water_error"), 0.0, 1e-12);
  EXPECT_EQ(fluid.counters().at("lost, far outside"), 0.0);
}

}  // namespace
}  // namespace poretwin::fluid
