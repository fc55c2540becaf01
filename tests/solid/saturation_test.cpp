// Saturation from the water around the soil, and the cohesion that depends on it.
#include "tests/solid/scenes.hpp"

#include <gtest/gtest.h>

namespace poretwin::solid {
namespace {

using test::column;
using test::ColumnSpec;
using test::wet_inbox;

Case wetting_column(const ColumnSpec& spec) {
  Case scene = column(spec);
  scene.solid.model = SolidCase::Model::drucker_prager;
  Soil& soil = scene.soils.front();
  soil.friction_angle = 35.0;
  soil.cohesion = 5000.0;
  soil.saturated_cohesion = 10.0;
  soil.initial_saturation = 0.2;
  return scene;
}

TEST(Saturation, WaterCountsAgainstTheSoilsOwnShareOfTheSurroundings) {
  ColumnSpec spec;
  Solid<2> solid(wetting_column(spec));
  const auto& s = solid.state().external.saturation.values();
  solid.initialise({});
  for (const double x : s) EXPECT_EQ(x, 0.2);  // without water: the case's value
  solid.advance({1, 0.0, 1e-4}, wet_inbox<2>(
                                    solid, [](const Vec<2>&) { return 0.0; }, 0.8));
  const auto& position = solid.state().particles.position;
  for (std::size_t i = 0; i < s.size(); ++i) {
    if (position[i].y() < 0.8) {
      EXPECT_NEAR(s[i], 0.2 + 0.8 * 0.8 / 0.95, 0.02);  // partly in water: a phreatic surface
    } else if (position[i].y() > 0.96) {
      EXPECT_EQ(s[i], 1.0);  // as much water as soil around it: saturated up to its surface
    }
  }
  solid.advance({2, 1e-4, 1e-4}, wet_inbox<2>(
                                     solid, [](const Vec<2>&) { return 0.0; }, 0.96));
  for (const double x : s) EXPECT_EQ(x, 1.0);
}

TEST(Saturation, WettingLetsAColumnFail) {
  // A free-standing column, 0.2 m wide, 0.6 m high: a cohesion of 5 kPa supports it, 10 Pa does not.
  ColumnSpec spec;
  spec.width = 0.2;
  spec.height = 0.6;
  spec.sides = false;
  Case scene = wetting_column(spec);
  scene.fluid.drag = scene.fluid.skeleton_response = false;  // water without force on the soil
  Solid<2> solid(scene);
  solid.initialise({});
  auto moved = [&] {
    double most = 0.0;
    for (std::size_t i = 0; i < solid.state().particles.size(); ++i)
      most = std::max(most, (solid.state().particles.displacement[i] - solid.state().rest_displacement[i]).norm());
    return most;
  };
  test::run_dry(solid, 0.1, 2e-3);
  EXPECT_LT(moved(), 1e-4);
  for (std::uint64_t k = 0; k < 100; ++k) {
    auto wet = wet_inbox<2>(solid, [](const Vec<2>&) { return 0.0; });
    solid.advance({100 + k, solid.state().time, 2e-3}, wet);
  }
  EXPECT_GT(moved(), 1e-2);
}

}  // namespace
}  // namespace poretwin::solid
