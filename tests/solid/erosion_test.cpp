// Soil that free water carries off: the length of its surface, the law of retreat, balances, and what stays as it was.
#include "solid_solver/erosion/erosion.hpp"
#include "tests/solid/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

namespace poretwin::solid {
namespace {

using test::column;
using test::ColumnSpec;

constexpr double friction_factor = 0.08, critical = 2.0, erodibility = 1e-3;  // -, Pa, m3/(N s)
constexpr double dx = 0.02, width = 0.2, height = 0.4;                        // m

/// A column of stiff elastic soil between rollers, which erodes under water with a shear stress of 10 Pa per
/// (m/s)^2.
Case erodible_column() {
  ColumnSpec spec;
  spec.width = width;
  spec.height = height;
  spec.spacing = dx;
  Case scene = column(spec);
  scene.soils[0].youngs_modulus = 1e9;
  scene.soils[0].erosion.emplace();
  scene.soils[0].erosion->friction_factor = friction_factor;
  scene.soils[0].erosion->numbers = {{"critical_shear_stress", critical}, {"erodibility", erodibility}};
  scene.fluid.regions = {scene.soils[0].shape};
  scene.fluid.particle_spacing = dx;
  return scene;
}

/// The inbox of a fluid whose free water has this velocity [m/s] everywhere.
coupling::Inbox under(const Solid<2>& solid, const Vec<2>& velocity) {
  auto inbox = test::wet_inbox<2>(solid, [](const Vec<2>&) { return 0.0; });
  coupling::Field field{std::string(coupling::field::free_velocity), 2, {}};
  for (std::size_t i = 0; i < solid.state().particles.size(); ++i)
    field.values.insert(field.values.end(), velocity.data(), velocity.data() + 2);
  inbox.fields.push_back(std::move(field));
  return inbox;
}

void run_under(Solid<2>& solid, const Vec<2>& velocity, double end, double interval) {
  while (solid.state().time < end - 1e-9)
    ASSERT_TRUE(solid.advance({0, solid.state().time, interval}, under(solid, velocity)).accepted);
}

/// Volume of the grains in place [m2].
double grains_in(const Solid<2>& solid) {
  double sum = 0.0;
  const auto& p = solid.state().particles;
  for (std::size_t i = 0; i < p.size(); ++i) sum += p.mass[i] / 2600.0;
  return sum;
}

/// A grain alone and two grains together above a column are not its crest; a row of grains is.
TEST(Erosion, TheCrestIsNotAGrainInFlight) {
  for (const int grains : {1, 2, 8}) {
    Case scene = erodible_column();
    scene.solid.initial_rest = false;
    Soil above = scene.soils[0];
    above.name = "grains";
    above.shape.min = Point3(dx, height + 5.0 * dx, 0.0);
    above.shape.max = above.shape.min + Point3(grains * dx, dx, 0.0);
    scene.soils.push_back(above);
    scene.gauges = {test::whole("crest_level")};
    Solid<2> solid(scene);
    solid.initialise(test::wet_inbox<2>(solid, [](const Vec<2>&) { return 0.0; }));
    EXPECT_NEAR(solid.gauges()[0].value, grains < 8 ? height : height + 6.0 * dx, 1e-9) << grains << " grains";
  }
}

/// A slope has its length, whatever its angle to the lattice, and its normal.
TEST(Erosion, TheSurfaceHasItsLengthAtAnyAngleToTheLattice) {
  double largest = 0.0;
  for (int angle = 0; angle <= 45; angle += 5) {
    const double rise = std::tan(angle * std::numbers::pi / 180.0);
    Case scene = erodible_column();
    scene.walls.clear();
    scene.soils[0].shape.kind = Shape::Kind::polygon;
    scene.soils[0].shape.points = {Point3(0.0, -1.0, 0.0), Point3(2.0, -1.0, 0.0), Point3(2.0, 2.0 * rise, 0.0),
                                   Point3(0.0, 0.0, 0.0)};
    scene.solid.initial_rest = false;
    const Solid<2> solid(scene);
    const auto parts = surface_parts(solid.setup(), solid.state());
    const Vec<2> down = Vec<2>(rise, -1.0).normalized();
    double length = 0.0;
    Vec<2> sum = Vec<2>::Zero();
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const Vec<2>& x = solid.state().particles.position[i];
      if (x.x() < 0.5 || x.x() > 1.5 || x.y() < rise * x.x() - 0.2) continue;
      length += parts[i].per_volume * dx * dx;
      sum += parts[i].per_volume * dx * dx * parts[i].normal;
    }
    const double exact = std::hypot(1.0, rise);
    largest = std::max(largest, std::abs(length / exact - 1.0));
    EXPECT_NEAR(length, exact, angle == 0 ? 1e-6 : 0.05 * exact) << angle;
    EXPECT_GT(sum.dot(down), 0.999 * sum.norm()) << angle;
  }
  std::printf("length of a surface: off by at most %.3f\n", largest);
}

/// Under a uniform shear stress the surface retreats by k_d (tau - tau_c) t, row by row, whatever the spacing of
/// windows.
TEST(Erosion, ABedRetreatsByItsLaw) {
  constexpr double speed = 1.0, shear = friction_factor / 8.0 * 1000.0 * speed * speed;
  constexpr double retreat = erodibility * (shear - critical);  // m/s
  for (const double interval : {0.02, 0.1}) {
    Solid<2> solid(erodible_column());
    solid.initialise(under(solid, Vec<2>::Zero()));
    const double before = grains_in(solid);
    const auto lost = [&] { return solid.state().erosion.grains / (0.6 * width); };
    double worst = 0.0;
    for (int row = 1; row <= 12; ++row) {
      run_under(solid, Vec<2>(speed, 0.0), (row + 0.5) * dx / retreat, interval);
      worst = std::max(worst, std::abs(lost() - row * dx));
      EXPECT_NEAR(grains_in(solid) + solid.state().erosion.grains, before, 1e-12 * before);
    }
    std::printf("windows of %g s: off by at most %.3f rows in 12\n", interval, worst / dx);
    EXPECT_LT(worst, 1e-9);
  }
}

/// Water that runs into the surface, or whose shear stress is below the critical one, carries nothing off.
TEST(Erosion, OnlyShearBeyondTheCriticalErodes) {
  const double least = std::sqrt(8.0 * critical / (friction_factor * 1000.0));  // m/s
  for (const Vec<2>& velocity : {Vec<2>(0.0, -3.0), Vec<2>(0.999 * least, 0.0), Vec<2>(0.0, 0.0)}) {
    Solid<2> solid(erodible_column());
    solid.initialise(under(solid, Vec<2>::Zero()));
    run_under(solid, velocity, 1.0, 0.1);
    for (const double share : solid.state().erosion.share) EXPECT_NEAR(share, 0.0, 1e-12);
  }
  Solid<2> solid(erodible_column());
  solid.initialise(under(solid, Vec<2>::Zero()));
  run_under(solid, Vec<2>(1.01 * least, 0.0), 1.0, 0.1);
  double lost = 0.0;
  for (const double share : solid.state().erosion.share) lost += share * dx * dx;
  const double exact = width * erodibility * critical * (1.01 * 1.01 - 1.0);
  EXPECT_NEAR(lost, exact, 1e-3 * exact);
}

/// What the leaving of a particle changes: nothing of the others, but for the forces of its neighbours.
TEST(Erosion, OthersKeepTheirState) {
  Case scene = erodible_column();
  Solid<2> solid(scene);
  solid.initialise(under(solid, Vec<2>::Zero()));
  State<2> state = solid.state();
  OrZero<double> water;
  water.allocate(2 * state.particles.size());
  std::size_t leaves = 0;  // a particle in the middle of the surface
  for (std::size_t i = 0; i < state.particles.size(); ++i)
    if ((state.particles.position[i] - Vec<2>(0.5 * width, height)).norm() <
        (state.particles.position[leaves] - Vec<2>(0.5 * width, height)).norm())
      leaves = i;
  water.values()[2 * leaves] = 3.0;
  const Vec<2> place = state.particles.position[leaves];
  const State<2> before = state;
  erode(solid.setup(), 10.0, water, state);
  ASSERT_EQ(state.particles.size(), before.particles.size() - 1);
  EXPECT_EQ(state.erosion.particles, 1.0);
  for (std::size_t i = 0; i < state.particles.size(); ++i) {
    const std::size_t j = i < leaves ? i : i + 1;
    EXPECT_EQ(state.erosion.first_number[i], j);
    EXPECT_EQ(state.particles.position[i], before.particles.position[j]);
    EXPECT_EQ(state.particles.stress[i], before.particles.stress[j]);
    EXPECT_EQ(state.external.pressure[i], before.external.pressure[j]);
    EXPECT_EQ(state.nodes[i].deformation, before.nodes[j].deformation);
    EXPECT_EQ(state.particles.mass[i], before.particles.mass[j]);
    const bool far = (state.particles.position[i] - place).norm() > 2.0 * solid.setup().range();
    EXPECT_LT((state.force[i].internal() - before.force[j].internal()).norm(), far ? 1e-9 * 15e3 : HUGE_VAL);
  }
}

/// A grain that erosion has left by itself belongs to no body: the stream takes it at once, a corner of a body it
/// erodes.
TEST(Erosion, AGrainByItselfIsCarriedOffAtOnce) {
  for (const double side : {dx, 4.0 * dx}) {
    Case scene = erodible_column();
    scene.walls.clear();
    scene.solid.initial_rest = false;
    scene.soils[0].shape.max = Point3(side, side, 0.0);
    Soil away = scene.soils[0];
    away.shape.min = Point3(1.0, 0.0, 0.0);
    away.shape.max = Point3(1.2, 0.2, 0.0);
    scene.soils.push_back(away);
    const Solid<2> solid(scene);
    State<2> state = solid.state();
    const std::size_t before = state.particles.size();
    OrZero<double> water;
    water.allocate(2 * before);
    for (std::size_t i = 0; i < before; ++i) water.values()[2 * i] = 1.0;
    erode(solid.setup(), 1e-3, water, state);
    EXPECT_EQ(before - state.particles.size(), side == dx ? 1 : 0);
  }
}

/// A run that is saved and resumed while the bed erodes continues to the bit, with its long windows' stiffness.
TEST(Erosion, IsResumedToTheBit) {
  Case scene = erodible_column();
  Solid<2> solid(scene), resumed(scene);
  solid.initialise(under(solid, Vec<2>::Zero()));
  run_under(solid, Vec<2>(1.0, 0.0), 5.0, 0.1);
  ASSERT_GT(solid.state().erosion.particles, 0.0);
  Archive out;
  solid.archive(out);
  Archive in{out.bytes()};
  resumed.archive(in);
  for (auto* one : {&solid, &resumed}) run_under(*one, Vec<2>(1.0, 0.0), 10.0, 0.1);
  Archive a, b;
  solid.archive(a);
  resumed.archive(b);
  EXPECT_TRUE(a.bytes() == b.bytes());
}

}  // namespace
}  // namespace poretwin::solid
