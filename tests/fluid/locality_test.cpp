// No property of a particle changes the equations of another particle beyond its reach: with and without a drop or
// puddle far away, the fields are the same after 20 prescribed windows.
#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/scenes.hpp"

#include <gtest/gtest.h>

namespace poretwin::fluid {
namespace {

using namespace test;

constexpr double dx = 0.01;

/// Seepage through a block of soil from a reservoir on its left to the air on its right, with a water table.
Case seeping_block() {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = dx;
  scene.fluid.pressure_tolerance = 1e-14;
  scene.soils = {sand()};
  scene.soils[0].hydraulic_conductivity = 1e-3;
  scene.soils[0].shape = box(0.0, 0.0, 0.2, 0.2);
  scene.walls = {wall(line(0.0, 0.0, 0.2, 0.0))};
  scene.water_faces = {head_face(line(0.0, 0.2, 0.0, 0.0), 0.15), pressure_face(line(0.2, 0.0, 0.2, 0.2), 0.0)};
  scene.fluid.regions = {box(0.0, 0.0, 0.1, 0.15)};
  return scene;
}

/// Free water that flows out of a column.
Case breaking_dam() {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = dx;
  scene.fluid.pressure_tolerance = 1e-14;
  scene.walls = {wall(line(0.0, 0.4, 0.0, 0.0)), wall(line(0.0, 0.0, 0.4, 0.0)), wall(line(0.4, 0.0, 0.4, 0.4))};
  scene.fluid.regions = {box(0.0, 0.0, 0.1, 0.15)};
  return scene;
}

/// Twenty windows of both; compares each particle of the first with the nearest of the second, relative bound `most`.
void expect_the_same(const Case& alone, const Case& beside, double interval, double most = 1e-10) {
  Fluid<2> one(alone), other(beside);
  one.initialise({});
  other.initialise({});
  for (std::uint64_t step = 0; step < 20; ++step) {
    const coupling::Window window{step, static_cast<double>(step) * interval, interval};
    one.advance(window, {});
    other.advance(window, {});
  }
  const auto &a = one.state().particles, &b = other.state().particles;
  const auto nearest = [&](const Vec<2>& x) {
    std::size_t best = 0;
    for (std::size_t j = 0; j < b.size(); ++j)
      if ((b.position[j] - x).squaredNorm() < (b.position[best] - x).squaredNorm()) best = j;
    return best;
  };
  double fastest = 0.0, moved = 0.0, differs = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const std::size_t j = nearest(a.position[i]);
    fastest = std::max(fastest, a.velocity[i].norm());
    moved = std::max(moved, (a.position[i] - b.position[j]).norm());
    differs = std::max(differs, (a.velocity[i] - b.velocity[j]).norm());
  }
  EXPECT_GT(fastest, 0.0);
  EXPECT_LT(moved, most * dx);
  EXPECT_LT(differs, most * std::max(fastest, 1e-3));
}

TEST(Locality, ADropFarAwayLeavesSeepageAsItIs) {
  Case beside = seeping_block();
  beside.fluid.regions.push_back(box(1.0, 0.1, 1.03, 0.13));
  expect_the_same(seeping_block(), beside, 1e-3);
}

TEST(Locality, APuddleFarAwayLeavesSeepageAsItIs) {
  Case beside = seeping_block();
  beside.walls.push_back(wall(line(1.0, 0.1, 1.0, 0.0)));
  beside.walls.push_back(wall(line(1.0, 0.0, 1.1, 0.0)));
  beside.walls.push_back(wall(line(1.1, 0.0, 1.1, 0.1)));
  beside.fluid.regions.push_back(box(1.0, 0.0, 1.1, 0.05));
  expect_the_same(seeping_block(), beside, 1e-3);
}

TEST(Locality, ADropFarAwayLeavesFreeWaterAsItIs) {
  Case beside = breaking_dam();
  beside.fluid.regions.push_back(box(1.0, 0.1, 1.03, 0.13));
  expect_the_same(breaking_dam(), beside, 1e-3, 1e-8);  // the solve ends at 1e-12 of the right-hand side
}

TEST(Locality, ADeepPoolFarAwayLeavesFreeWaterAsItIs) {
  Case beside = breaking_dam();
  for (const auto& side : {line(1.0, 0.4, 1.0, -0.2), line(1.0, -0.2, 1.1, -0.2), line(1.1, -0.2, 1.1, 0.4)})
    beside.walls.push_back(wall(side));
  beside.fluid.regions.push_back(box(1.0, -0.2, 1.1, 0.3));
  expect_the_same(breaking_dam(), beside, 1e-3, 1e-8);
}

TEST(Locality, ABlockOfSoilFarAwayLeavesFreeWaterAsItIs) {
  Case beside = breaking_dam();
  beside.soils = {sand()};
  beside.soils[0].hydraulic_conductivity = 1e-3;
  beside.soils[0].shape = box(1.0, 0.0, 1.1, 0.1);
  beside.walls.push_back(wall(line(1.1, 0.0, 1.1, 0.1)));
  beside.walls.push_back(wall(line(1.0, 0.1, 1.0, 0.0)));
  beside.walls.push_back(wall(line(1.0, 0.0, 1.1, 0.0)));
  beside.fluid.regions.push_back(box(1.0, 0.0, 1.1, 0.05));
  expect_the_same(breaking_dam(), beside, 1e-3, 1e-8);
}

TEST(Locality, AFastDropFarAwayLeavesFreeWaterAsItIs) {
  Case beside = breaking_dam();
  beside.fluid.regions.push_back(box(1.0, 0.5, 1.03, 0.53));
  expect_the_same(breaking_dam(), beside, 1e-3, 1e-8);
}

/// A block of soil that is full of water, between two reservoirs.
void add_full_block(double left, double right, double head, Case& scene) {
  scene.soils.push_back(sand());
  scene.soils.back().shape = box(left, 0.0, right, 0.1);
  scene.walls.push_back(wall(line(left, 0.0, right, 0.0)));
  scene.walls.push_back(wall(line(right, 0.1, left, 0.1)));
  scene.water_faces.push_back(head_face(line(left, 0.1, left, 0.0), head));
  scene.water_faces.push_back(head_face(line(right, 0.0, right, 0.1), 0.2));
  scene.fluid.regions.push_back(box(left, 0.0, right, 0.1));
}

/// Points in full soil are evened out without volume on the whole: of each block, not of both together.
TEST(Locality, AnotherFullBlockFarAwayLeavesAFullBlockAsItIs) {
  Case alone;
  alone.solid.model = SolidCase::Model::rigid;
  alone.fluid.particle_spacing = dx;
  alone.fluid.pressure_tolerance = 1e-11;
  add_full_block(0.0, 0.2, 0.3, alone);
  Case beside = alone;
  add_full_block(1.0, 1.1, 0.35, beside);
  expect_the_same(alone, beside, 5.0, 1e-3);  // the displacements are found to a tolerance of their own
}

/// A box full of disordered water, without a free surface.
Case closed_box() {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = dx;
  scene.fluid.pressure_tolerance = 1e-14;
  scene.fluid.jitter = 0.2;
  scene.fluid.initial_strain = 1.0;
  scene.walls = {wall(line(0.0, 0.1, 0.0, 0.0)), wall(line(0.0, 0.0, 0.1, 0.0)), wall(line(0.1, 0.0, 0.1, 0.1)),
                 wall(line(0.1, 0.1, 0.0, 0.1))};
  scene.fluid.regions = {box(0.0, 0.0, 0.1, 0.1)};
  return scene;
}

TEST(Locality, ADropFarAwayLeavesAClosedBoxAsItIs) {
  Case beside = closed_box();
  beside.fluid.initial_strain = 1.0;
  beside.fluid.regions.push_back(box(1.0, 0.1, 1.03, 0.13));
  expect_the_same(closed_box(), beside, 1e-3, 1e-6);
}

}  // namespace
}  // namespace poretwin::fluid
