// The example of docs/extending/boundary.md in a run.
#include "docs/extending/tide.hpp"

#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/scenes.hpp"

#include <gtest/gtest.h>

namespace poretwin::fluid {
namespace {

using namespace test;

TEST(Tide, DrivesWaterThroughALayerAsItsLevelStands) {
  // A confined layer of length L and height a between the tide and tailwater at H2: q = k a (H(t) - H2) / L.
  const double k = 2e-3, a = 0.1, L = 0.2, H2 = 0.2, mean = 0.4, amplitude = 0.05, period = 10.0;
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = 0.02;
  scene.soils = {sand()};
  scene.soils[0].hydraulic_conductivity = k;
  scene.soils[0].shape = box(0.0, 0.0, L, a);
  scene.fluid.regions = {scene.soils[0].shape};
  scene.walls = {wall(line(0.0, 0.0, L, 0.0)), wall(line(L, a, 0.0, a))};
  scene.water_faces = {head_face(line(0.0, a, 0.0, 0.0), mean), head_face(line(L, 0.0, L, a), H2)};
  scene.water_faces[0].name = "sea";
  scene.gauges = {gauge("in", "passed_volume", {}, "sea"), gauge("level", "level", {}, "sea")};
  auto boundaries = make_water_boundaries(scene);
  boundaries[0] = std::make_unique<Tide>(mean, amplitude, period);
  Fluid<2> fluid(scene, std::move(boundaries));
  fluid.initialise({});
  double time = 0.0;
  const double turn = 2.0 * std::numbers::pi / period;
  run_to(fluid, time, 1.3);
  EXPECT_NEAR(reading(fluid, "level"), mean + amplitude * std::sin(1.3 * turn), 1e-12);
  EXPECT_EQ(fluid.proposal().second, "a tide");
  run_to(fluid, time, 0.5 * period);
  const double steady = k * a / L * (mean - H2) * time, by_tide = k * a / L * amplitude * 2.0 / turn;
  std::printf("passed %.4e m2, of it by the tide %.4e, exactly %.4e\n", reading(fluid, "in"),
              reading(fluid, "in") - steady, by_tide);
  EXPECT_NEAR(reading(fluid, "in") - steady, by_tide, 0.05 * by_tide);
}

}  // namespace
}  // namespace poretwin::fluid
