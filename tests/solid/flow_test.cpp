// Flowing soil: rough walls, periodic and symmetric sides, and the corrections that keep the flow regular.
#include "scenes.hpp"
#include "solid_solver/discretisation/rough_walls.hpp"
#include "solid_solver/dynamics/flow_regularisation.hpp"
#include "solid_solver/dynamics/step.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace poretwin::solid::test {
namespace {

constexpr double spacing = 0.05;

Face line(std::vector<Point3> points) {
  Face face;
  face.points = std::move(points);
  return face;
}

/// Ten rows of grains (angle of repose 31 degrees) on a rough base, periodic along x, with gravity turned by `slope`.
Case layer(double slope, double speed, int dimension = 2) {
  ColumnSpec spec;
  spec.dimension = dimension;
  spec.width = 0.4;
  spec.height = 0.5;
  spec.spacing = spacing;
  spec.base = Wall::ForSoil::none;
  spec.sides = false;
  Case scene = column(spec);
  const Point3 up = Point3::Unit(dimension - 1);
  scene.general.gravity = 9.81 * (std::sin(slope) * Point3::UnitX() - std::cos(slope) * up);
  scene.general.periodic = {0};
  if (dimension == 3) scene.general.periodic = {0, 1};
  scene.general.domain_max = dimension == 3 ? Point3(0.4, 0.4, 1.0) : Point3(0.4, 1.0, 0.0);
  scene.soils[0].friction_angle = 31.0;
  scene.soils[0].cone = Soil::Cone::repose;
  scene.solid.model = SolidCase::Model::drucker_prager;
  scene.solid.initial_velocity = {speed, 0.0, 0.0};
  Wall base;
  base.name = "base";
  base.face = dimension == 3 ? plane(Point3::Zero(), up) : line({{0.0, 0.0, 0.0}, {0.4, 0.0, 0.0}});
  base.soil = Wall::ForSoil::rough;
  scene.walls = {base};
  return scene;
}

template <int D>
double mean_speed(const Solid<D>& solid) {
  const auto& p = solid.state().particles;
  double sum = 0.0;
  for (std::size_t i = 0; i < p.free(); ++i) sum += p.velocity[i].x() / static_cast<double>(p.free());
  return sum;
}

/// Sixty substeps of grains that flow down a slope, computed in the given number of parts.
Particles<2> sixty_substeps(std::size_t parts) {
  auto [setup, particles] = set_up<2>(layer(0.6, 0.3));
  setup.parts = parts;
  State<2> state;
  state.particles = std::move(particles);
  const std::size_t n = state.particles.size();
  state.body.assign(n, Vec<2>::Zero());
  state.force.assign(n, {});
  state.yielded.assign(n, 0);
  state.particles.plastic_strain.assign(n, 0.1);
  rebuild(setup, state);
  evaluate_forces(setup, state);
  Drive<2> drive;
  for (int k = 0; k < 60; ++k) substep(setup, setup.longest_substep, drive, state);
  EXPECT_GT(state.rebuilds, 1.0);
  return state.particles;
}

TEST(Threads, ChangeNothingButRounding) {
  const auto one = sixty_substeps(1), three = sixty_substeps(3);
  double stress = 0.0;
  for (const auto& s : one.stress) stress = std::max(stress, s.norm());
  EXPECT_GT(stress, 0.0);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_LT((one.position[i] - three.position[i]).norm(), 1e-10 * spacing);
    EXPECT_LT((one.stress[i] - three.stress[i]).norm(), 1e-8 * stress);
  }
}

TEST(RoughWall, HoldsThreeRowsOfTheSoilAndClosesCorners) {
  Case scene = layer(0.0, 0.0);
  scene.general.periodic.clear();
  scene.walls[0].face = line({{0.0, 0.5, 0.0}, {0.0, 0.0, 0.0}, {0.4, 0.0, 0.0}, {0.4, 0.5, 0.0}});
  const Solid<2> solid(scene);
  const auto& p = solid.state().particles;
  EXPECT_EQ(p.free(), 80u);
  EXPECT_EQ(p.held, 3u * (10 + 8 + 10) + 2u * 9);  // three sides and two corners
  for (std::size_t i = p.free(); i < p.size(); ++i) {
    const Vec<2> x = p.position[i];
    EXPECT_FALSE(x.x() > 0.0 && x.x() < 0.4 && x.y() > 0.0) << x.transpose();
    for (std::size_t j = 0; j < p.size(); ++j) {
      if (j == i) continue;
      EXPECT_GT((p.position[j] - x).norm(), 0.7 * spacing);
    }
  }
}

TEST(RoughWall, AsksForAWallWithEnds) {
  Case scene = layer(0.0, 0.0);
  scene.walls[0].face = plane(Point3::Zero(), Point3::UnitY());
  EXPECT_THROW(Solid<2>{scene}, std::exception);
}

TEST(RoughWall, InThreeDimensionsHoldsThreeRowsWithinTheDomainAndClosesCorners) {
  Case scene = layer(0.0, 0.0, 3);
  scene.general.periodic = {1};
  Wall side = scene.walls[0], back = side;
  side.face = plane(Point3::Zero(), Point3::UnitX());
  back.face = plane(0.4 * Point3::UnitX(), -Point3::UnitX());
  back.soil = Wall::ForSoil::roller;
  scene.walls = {scene.walls[0], side, back};
  const Solid<3> solid(scene);
  const auto& p = solid.state().particles;
  EXPECT_EQ(p.free(), 640u);
  EXPECT_EQ(p.held, 8u * 3u * (8 + 3 + 20 + 3));  // the base with its corner, the side up to three rows over the box
  for (std::size_t i = p.free(); i < p.size(); ++i) {
    const Vec<3> x = p.position[i];
    EXPECT_TRUE(x.x() < 0.4 && (x.x() < 0.0 || x.z() < 0.0)) << x.transpose();
    for (std::size_t j = 0; j < i; ++j) EXPECT_GT((p.position[j] - x).norm(), 0.99 * spacing);
  }
  scene.general.domain_max = Point3(0.0, 0.4, 0.0);
  EXPECT_THROW(Solid<3>{scene}, CaseError);
}

template <int D>
void expect_coulomb() {
  for (const double degrees : {27.0, 35.0}) {
    const double slope = degrees * 3.14159265358979 / 180.0, friction = std::tan(31.0 * 3.14159265358979 / 180.0);
    Solid<D> solid(layer(slope, 1.0, D));
    solid.initialise({});
    run_dry(solid, 0.1, 0.01);
    const double before = mean_speed(solid);
    run_dry(solid, 0.6, 0.01);
    const double found = (mean_speed(solid) - before) / 0.5;
    const double exact = 9.81 * (std::sin(slope) - friction * std::cos(slope));
    EXPECT_NEAR(found, exact, 0.25 * std::abs(exact)) << degrees;
    for (const auto& x : solid.state().near.built_at) {  // nothing leaves the box
      EXPECT_GE(x.x(), 0.0);
      EXPECT_LE(x.x(), 0.4);
    }
  }
}

TEST(InfiniteSlope, SlowsDownBelowItsAngleOfReposeAndSpeedsUpAboveIt) {
  expect_coulomb<2>();
  expect_coulomb<3>();
}

TEST(InfiniteSlope, FrictionDoesNotDependOnTheThicknessOfTheSheet) {
  // Sheets of a few particles neither stick (inadmissible tension) nor float (viscous lift) over the fixed particles of
  // the base. A single row collides with the bumps of its bed, which brakes it more.
  for (const int rows : {2, 3}) {
    const double slope = 35.0 * 3.14159265358979 / 180.0, friction = std::tan(31.0 * 3.14159265358979 / 180.0);
    Case scene = layer(slope, 1.5);
    scene.soils[0].shape.max.y() = rows * spacing;
    Solid<2> solid(scene);
    solid.initialise({});
    run_dry(solid, 0.1, 0.01);
    const double before = mean_speed(solid);
    run_dry(solid, 0.9, 0.01);
    const double found = (mean_speed(solid) - before) / 0.8;
    const double degree = 9.81 / std::cos(slope) * 3.14159265358979 / 180.0;
    EXPECT_NEAR(found, 9.81 * (std::sin(slope) - friction * std::cos(slope)), 3.0 * degree) << rows;
  }
}

TEST(PeriodicSides, AreNoSides) {
  // Level ground settles under its weight as between rollers.
  Case scene = layer(0.0, 0.0);
  scene.solid.model = SolidCase::Model::elastic;
  Solid<2> periodic(scene);
  periodic.initialise({});
  scene.general.periodic.clear();
  for (const double side : {0.0, 0.4}) {
    Wall wall;
    wall.face = plane({side, 0.0, 0.0}, (side > 0.0 ? -1.0 : 1.0) * Point3::UnitX());
    wall.soil = Wall::ForSoil::roller;
    scene.walls.push_back(wall);
  }
  Solid<2> between(scene);
  between.initialise({});
  const auto &a = periodic.state().particles, &b = between.state().particles;
  for (std::size_t i = 0; i < a.free(); ++i) {
    EXPECT_NEAR(a.displacement[i].y(), b.displacement[i].y(), 1e-6 * 0.5);
    EXPECT_NEAR(a.stress[i][1], b.stress[i][1], 1.0);
  }
}

TEST(SymmetricSide, ShowsTheOtherHalf) {
  // A column without side walls, and its right half beside a roller.
  Case half = layer(0.0, 0.0);
  half.general.periodic.clear();
  half.solid.initial_rest = false;
  half.walls[0].face = line({{0.0, 0.0, 0.0}, {1.2, 0.0, 0.0}});
  Case whole = half;
  whole.walls[0].face = line({{-1.2, 0.0, 0.0}, {1.2, 0.0, 0.0}});
  whole.soils[0].shape.min.x() = -0.4;
  Wall middle;
  middle.face = plane(Point3::Zero(), Point3::UnitX());
  middle.soil = Wall::ForSoil::roller;
  half.walls.push_back(middle);
  Solid<2> a(half), b(whole);
  a.initialise({});
  b.initialise({});
  run_dry(a, 0.1, 0.01);
  run_dry(b, 0.1, 0.01);
  auto front = [](const Solid<2>& solid) {
    double x = 0.0;
    for (std::size_t i = 0; i < solid.state().particles.free(); ++i)
      x = std::max(x, solid.state().particles.position[i].x());
    return x;
  };
  EXPECT_GT(front(a), 0.38);
  EXPECT_NEAR(front(a), front(b), 0.02 * spacing);
}

TEST(RegularFlow, LeavesAloneWhatDoesNotFlowAndWhatIsLinear) {
  Case scene = layer(0.0, 0.0);
  scene.soils[0].dilation_angle = 5.0;  // so that the density changes
  Solid<2> solid(scene);
  const auto [setup, unused] = set_up<2>(scene);
  State<2> state = solid.state();
  auto linear = [](const Vec<2>& x) {
    Tensor s = Tensor::Zero();
    s[0] = s[1] = s[2] = -1000.0 + 500.0 * x.y();
    return s;
  };
  for (std::size_t i = 0; i < state.particles.size(); ++i)
    state.particles.stress[i] = linear(state.particles.position[i]);
  auto disturb = [](State<2>& s) { s.particles.stress[44][1] += 100.0; };
  State<2> resting = state;
  disturb(resting);
  State<2> expected = resting;
  keep_flow_regular<2>(setup, 1.0, true, resting);
  EXPECT_EQ(resting.particles.stress[44], expected.particles.stress[44]);
  // Soil that has flowed and is at rest again is not changed, either.
  std::fill_n(state.particles.plastic_strain.begin(), state.particles.free(), 1.0);
  State<2> stopped = state;
  disturb(stopped);
  keep_flow_regular<2>(setup, 1.0, false, stopped);
  EXPECT_EQ(stopped.particles.stress[44], expected.particles.stress[44]);
  for (auto& node : state.nodes) node.gradient << 0.0, 0.01, 0.0, 0.0;  // 1/s, in 1 s
  State<2> smooth = state, noisy = state;
  keep_flow_regular<2>(setup, 1.0, false, smooth);
  for (std::size_t i = 0; i < state.particles.size(); ++i) {
    EXPECT_LT((smooth.particles.stress[i] - state.particles.stress[i]).norm(), 1e-9 * 1000.0);
    const double depth = 0.5 - state.particles.position[i].y();
    if (i >= state.particles.free() || depth < 3.0 * spacing) continue;
    EXPECT_NEAR(smooth.particles.volume[i], state.particles.volume[i],
                1e-12 * state.particles.volume[i]);  // density as at time zero
  }
  disturb(noisy);
  keep_flow_regular<2>(setup, 1.0, false, noisy);
  const double left = noisy.particles.stress[44][1] - state.particles.stress[44][1];
  EXPECT_LT(left, 80.0);
  EXPECT_GT(left, 0.0);
}

TEST(RegularFlow, EvensOutVolumesOfWetSoilByWhatItYields) {
  const Case scene = layer(0.0, 0.0);
  Solid<2> solid(scene);
  const auto [setup, unused] = set_up<2>(scene);
  State<2> state = solid.state();
  auto& p = state.particles;
  std::fill_n(p.plastic_strain.begin(), p.free(), 1.0);
  for (auto& node : state.nodes) node.gradient << 0.0, 0.01, 0.0, 0.0;  // 1/s, in 1 s
  const double before = p.volume[44];
  const auto evened = [&](double coverage, float yielded) {
    State<2> treated = state;
    treated.evened.assign(p.size(), 1.0F - yielded);
    treated.external.coverage = ScalarArray(p.size(), coverage);
    treated.particles.volume[44] = 1.01 * before;
    keep_flow_regular<2>(setup, 1.0, false, treated);
    return 1.01 - treated.particles.volume[44] / before;
  };
  const double in_full = evened(1.0, 0.01F);
  EXPECT_GT(in_full, 0.001);
  EXPECT_NEAR(evened(1.0, 1e-4F), 0.1 * in_full, 0.002 * in_full);
  EXPECT_LT(evened(1.0, 0.0F), 1e-12);
  EXPECT_GT(evened(0.0, 0.0F), 0.9 * in_full);  // dry soil, by what it shears
}

TEST(RegularFlow, EvensOutStressWhereSoilYieldedALittleAndNothingElse) {
  Case scene = layer(0.0, 0.0);
  scene.soils[0].cohesion = 2000.0;  // the disturbance itself is within the cone
  Solid<2> solid(scene);
  const auto [setup, unused] = set_up<2>(scene);
  State<2> state = solid.state();
  auto& p = state.particles;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double linear = -1000.0 + 500.0 * p.position[i].y();
    p.stress[i] << linear - 400.0, linear, linear, 0.0, 0.0, 0.0;
    p.plastic_strain[i] = i < p.free() ? 0.005 : 0.0;
  }
  state.evened.assign(p.plastic_strain.begin(), p.plastic_strain.end());
  const auto treat = [&](double since, bool disturbed, bool in_equilibrium = true) {
    State<2> treated = state;
    for (std::size_t i = 0; i < p.free(); ++i) treated.evened[i] -= static_cast<float>(since);
    if (disturbed) treated.particles.stress[44][1] += 100.0;
    keep_flow_regular<2>(setup, 1.0, in_equilibrium, treated);
    EXPECT_EQ(treated.particles.volume, p.volume);
    EXPECT_EQ(treated.particles.position, p.position);
    return treated.particles.stress;
  };
  // Soil that has yielded and rests is not changed; nor is soil that moves, nor a linear stress.
  EXPECT_EQ(treat(1e-3, true, false)[44][1], p.stress[44][1] + 100.0);
  EXPECT_EQ(treat(0.0, true)[44][1], p.stress[44][1] + 100.0);
  const auto smooth = treat(1e-3, false);
  for (std::size_t i = 0; i < p.size(); ++i) EXPECT_LT((smooth[i] - p.stress[i]).norm(), 1e-9 * 1000.0);
  const auto left = [&](double since) { return treat(since, true)[44][1] - p.stress[44][1]; };
  const double wholly = left(1e-3);
  EXPECT_LT(wholly, 80.0);
  EXPECT_GT(wholly, 0.0);
  // The correction is proportional to the plastic strain while that is small: half of three times G times it, if all
  // neighbours differed in the same direction (their gradients explain part of the difference).
  const double since = 1e-6, most = 0.5 * 3.0 * setup.models[0]->initial_moduli().shear * since;
  const double evened = 100.0 - left(since), twice = 100.0 - left(2.0 * since);
  EXPECT_LT(evened, most);
  EXPECT_GT(evened, 0.55 * most);
  EXPECT_NEAR(twice, 2.0 * evened, 0.05 * twice);
}

}  // namespace
}  // namespace poretwin::solid::test
