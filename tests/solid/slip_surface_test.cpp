// The weakest link of a slip surface, for prescribed strain fields.
#include "solid_solver/output/slip_surface.hpp"

#include "solid_solver/output/gauges.hpp"
#include "tests/solid/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace poretwin::solid {
namespace {

TEST(SlipSurface, IsAsStrongAsItsWeakestLink) {
  test::ColumnSpec spec;
  spec.gravity = 0.0;
  Case scene = test::column(spec);
  Gauge gauge = test::whole("slip_surface");
  gauge.points = {{0.0, 0.2, 0.0}, {0.0, 0.3, 0.0}, {0.4, 0.0, 0.0}, {0.4, 1.0, 0.0}};
  scene.gauges = {gauge};
  Solid<2> solid(scene);
  solid.initialise({});
  State<2> state = solid.state();
  const auto read = [&] { return read_gauges<2>(solid.setup(), state).front().value; };
  EXPECT_EQ(read(), 0.0);  // no shear strain

  // A band that rises by one row per column from (0, 0.225) at the left side, with strain 0.5 except for 0.07 at one
  // place. Beside it soil with strain 0.01, and higher up a stronger band that does not begin where the slip surface
  // must begin.
  const auto at = [&](std::size_t i, int d) {
    return static_cast<int>(std::floor(state.particles.position[i][d] / spec.spacing));
  };
  const auto draw = [&](double link) {
    for (std::size_t i = 0; i < state.particles.free(); ++i) {
      const int column = at(i, 0), row = at(i, 1);
      const bool band = row == 4 + column;
      state.particles.plastic_strain[i] = row == 18 ? 1.0 : !band ? 0.01 : column == 4 ? link : 0.5;
    }
  };
  draw(0.07);
  EXPECT_EQ(read(), 0.07);
  draw(0.0);
  EXPECT_EQ(read(), 0.01);  // around the gap
  scene.gauges[0].points[2] = scene.gauges[0].points[3] = {0.8, 0.5, 0.0};
  const Solid<2> asked_beside(scene);
  EXPECT_EQ(read_gauges<2>(asked_beside.setup(), state).front().value, 0.0);  // no soil there
}

}  // namespace
}  // namespace poretwin::solid
