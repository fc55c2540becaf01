// Walls with Coulomb friction: a layer of soil on an inclined plane sticks as at a fixed wall, or slides like a block,
// in 2D and 3D.
#include "scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace poretwin::solid::test {
namespace {

constexpr double spacing = 0.05, g = 9.81, density = 1560.0, degrees = std::numbers::pi / 180.0;
const double friction = std::tan(20.0 * degrees);

/// An endless layer on a frictional plane (20 degrees), with gravity turned by `slope`; soil with a friction of 31
/// degrees.
Case layer(int dimension, double slope, int rows, const Point3& velocity = Point3::Zero()) {
  ColumnSpec spec;
  spec.dimension = dimension;
  spec.spacing = spacing;
  spec.width = dimension == 2 ? 0.4 : 0.3;
  spec.height = rows * spacing;
  spec.base = Wall::ForSoil::frictional;
  spec.sides = false;
  Case scene = column(spec);
  const int up = dimension - 1;
  scene.general.gravity = g * (std::sin(slope) * Point3::UnitX() - std::cos(slope) * Point3::Unit(up));
  scene.general.periodic = dimension == 2 ? std::vector<int>{0} : std::vector<int>{0, 1};
  scene.general.domain_max = Point3::Constant(spec.width);
  scene.general.domain_max[up] = 10.0;
  scene.walls[0].friction_angle = 20.0;
  scene.soils[0].friction_angle = 31.0;
  scene.soils[0].cone = Soil::Cone::repose;
  scene.solid.model = SolidCase::Model::drucker_prager;
  scene.solid.initial_velocity = velocity;
  return scene;
}

template <int D>
Vec<D> mean_velocity(const Solid<D>& solid) {
  const auto& p = solid.state().particles;
  Vec<D> sum = Vec<D>::Zero();
  for (std::size_t i = 0; i < p.free(); ++i) sum += p.velocity[i] / static_cast<double>(p.free());
  return sum;
}

/// Largest error of the shear stress along the slope, without the two rows at the surface, over that at the base.
template <int D>
double shear_error(const Solid<D>& solid, double slope, int rows) {
  const auto& p = solid.state().particles;
  const double base = density * g * std::sin(slope) * rows * spacing;
  double worst = 0.0;
  for (std::size_t i = 0; i < p.free(); ++i) {
    const double share = 1.0 - p.position[i][D - 1] / (rows * spacing);
    if (share * rows < 2.0) continue;
    worst = std::max(worst, std::abs(matrix_of<D>(p.stress[i])(0, D - 1) / base - share));
  }
  return worst;
}

template <int D>
void expect_rest(SolidCase::Model model, int rows) {
  const double slope = 18.0 * degrees;
  Case scene = layer(D, slope, rows);
  scene.solid.model = model;
  Solid<D> solid(scene);
  solid.initialise({});
  EXPECT_LT(shear_error<D>(solid, slope, rows), 0.015);
  const double top = solid.state().particles.displacement.back().norm();
  run_dry(solid, 0.5, 0.01);
  EXPECT_LT(solid.state().particles.displacement.back().norm() - top, 0.01 * top);
  EXPECT_LT(shear_error<D>(solid, slope, rows), 0.015);
}

TEST(FrictionalWall, HoldsALayerBelowItsAngle) {
  for (const int rows : {5, 10, 20}) expect_rest<2>(SolidCase::Model::elastic, rows);
  expect_rest<2>(SolidCase::Model::drucker_prager, 10);
  expect_rest<3>(SolidCase::Model::drucker_prager, 8);
}

TEST(FrictionalWall, LetsALayerSlideLikeABlock) {
  for (const auto model : {SolidCase::Model::elastic, SolidCase::Model::drucker_prager})
    for (const double slope : {15.0 * degrees, 25.0 * degrees}) {
      Case scene = layer(2, slope, 10, {2.0, 0.0, 0.0});
      scene.solid.model = model;
      Solid<2> solid(scene);
      solid.initialise({});
      run_dry(solid, 0.1, 0.01);
      const double before = mean_velocity(solid).x();
      run_dry(solid, 0.5, 0.01);
      const double exact = g * (std::sin(slope) - friction * std::cos(slope));
      EXPECT_NEAR((mean_velocity(solid).x() - before) / 0.4, exact, 0.01 * friction * g) << slope / degrees;
    }
}

TEST(FrictionalWall, StopsALayerWhereABlockStops) {
  Solid<2> solid(layer(2, 0.0, 10, {1.0, 0.0, 0.0}));
  solid.initialise({});
  const VecArray<2> start = solid.state().particles.displacement;
  run_dry(solid, 0.6, 0.01);
  double way = 0.0;
  const auto& p = solid.state().particles;
  for (std::size_t i = 0; i < p.free(); ++i) way += (p.displacement[i] - start[i]).x() / static_cast<double>(p.free());
  EXPECT_NEAR(way, 0.5 / (friction * g), 0.02 * 0.5 / (friction * g));
}

/// Root mean square of what the velocities of the lowest row differ from their mean [m/s].
double unevenness(const Solid<2>& solid, std::size_t columns) {
  const auto& p = solid.state().particles;
  Vec<2> mean = Vec<2>::Zero();
  double square = 0.0, count = 0.0;
  for (int pass = 0; pass < 2; ++pass)
    for (std::size_t i = 0; i < p.free(); ++i) {
      if (p.position[i].y() > spacing) continue;
      if (pass == 0) mean += p.velocity[i] / static_cast<double>(columns);
      if (pass == 1) square += (p.velocity[i] - mean).squaredNorm(), count += 1.0;
    }
  EXPECT_EQ(count, static_cast<double>(columns));
  return std::sqrt(square / count);
}

// An elastic block that slides gives its waves some energy with every reflection at the wall (Adams 1995, J. Appl.
// Mech. 62): these grow by 15 per second, seventyfold in the time of the test, less what artificial viscosity takes.
// Without the changes of the stress along the wall (Particles::wall_slope) they would grow by 60 per second.
TEST(FrictionalWall, WavesAlongItGrowNoFasterThanTheyMust) {
  Case scene = layer(2, 0.0, 10, {2.0, 0.0, 0.0});
  scene.general.domain_max.x() = scene.soils[0].shape.max.x() = 1.0;
  scene.soils[0].cohesion = 1e5;
  scene.solid.jitter = 1e-6;
  Solid<2> solid(scene);
  solid.initialise({});
  run_dry(solid, 0.1, 0.01);
  const double before = unevenness(solid, 20);
  run_dry(solid, 0.38, 0.01);
  EXPECT_LT(unevenness(solid, 20), 70.0 * before);
}

TEST(FrictionalWall, ActsAgainstTheSlipWhicheverWayItGoes) {
  // Thrown across the slope (3D), the layer turns downhill as a block does.
  const double slope = 15.0 * degrees;
  Solid<3> solid(layer(3, slope, 5, {0.5, 1.0, 0.0}));
  solid.initialise({});
  run_dry(solid, 0.4, 0.01);
  Vec<2> block(0.5, 1.0);
  for (double t = 0.0; t < 0.4; t += 1e-5)
    block += 1e-5 * (g * std::sin(slope) * Vec<2>::UnitX() - friction * g * std::cos(slope) * block.normalized());
  const Vec<3> found = mean_velocity(solid);
  EXPECT_NEAR(found.x(), block.x(), 0.01);
  EXPECT_NEAR(found.y(), block.y(), 0.01);
}

TEST(FrictionalWall, IsOneWallInHoweverManyPieces) {
  Case scene = layer(2, 25.0 * degrees, 6, {1.0, 0.0, 0.0});
  scene.general.periodic.clear();
  scene.soils[0].shape.min.x() = 0.3;
  scene.soils[0].shape.max.x() = 0.7;
  scene.walls[0].face = {};
  scene.walls[0].face.points = {{0.0, 0.0, 0.0}, {4.0, 0.0, 0.0}};
  Case pieces = scene;
  pieces.walls[0].face.points = {{0.0, 0.0, 0.0}, {0.52, 0.0, 0.0}, {0.8, 0.0, 0.0}, {4.0, 0.0, 0.0}};
  Solid<2> whole(scene), divided(pieces);
  for (auto* solid : {&whole, &divided}) {
    solid->initialise({});
    run_dry(*solid, 0.1, 0.01);
  }
  for (std::size_t i = 0; i < whole.state().particles.free(); ++i)
    EXPECT_LT((whole.state().particles.position[i] - divided.state().particles.position[i]).norm(), 1e-6 * spacing);
}

}  // namespace
}  // namespace poretwin::solid::test
