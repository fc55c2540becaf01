// Free water, also in 3D: energy and hydrostatics.
#include "common/coupling/interrupt.hpp"
#include "fluid_solver/output/report.hpp"
#include "tests/fluid/energy.hpp"
#include "tests/fluid/scenes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>

namespace poretwin::fluid {
namespace {

using namespace test;

Case tank(double dx, double length, double jitter = 0.0) {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = dx;
  scene.fluid.regions = {box(0.0, 0.0, 0.4, 0.2)};
  scene.fluid.jitter = jitter;
  scene.walls = {wall(line(0.0, 1.0, 0.0, 0.0)), wall(line(0.0, 0.0, length, 0.0)),
                 wall(line(length, 0.0, length, 1.0))};
  return scene;
}

TEST(FreeWater, DisorderedTankStaysQuiet) {
  Fluid<2> fluid(tank(0.02, 0.4, 0.2));
  fluid.initialise({});
  double time = 0.0;
  run_to(fluid, time, 3.0);
  const auto& p = fluid.state().particles;
  double error = 0.0;
  for (std::size_t a = 0; a < p.size(); ++a) {
    error += p.pressure[a] * p.pressure[a] / static_cast<double>(p.size());
    EXPECT_LT(p.velocity[a].norm(), 0.2);  // 0.14 of sqrt(g H)
  }
  EXPECT_LT(std::sqrt(error) / (9810.0 * 0.2), 0.04);
}

// A particle that sinks out of a crowded surface row has neighbours, hence a pressure, and does not fall freely.
TEST(FreeWater, NothingFallsInATankAtRest) {
  Fluid<2> fluid(tank(0.01, 0.4, 0.2));
  fluid.initialise({});
  double time = 0.0;
  run_to(fluid, time, 3.0);
  for (int i = 1; i <= 500; ++i) {
    run_to(fluid, time, 3.0 + 0.01 * i);
    const auto& p = fluid.state().particles;
    for (std::size_t a = 0; a < p.size(); ++a)
      ASSERT_NE(p.surface[a], Surface::lone) << "at " << time << " s, " << p.position[a].transpose();
  }
}

TEST(FreeWater, ASignalEndsAWindowWhoseStartIsSaved) {
  Fluid<2> fluid(tank(0.02, 0.8));
  fluid.initialise({});
  const coupling::InterruptGuard guard;
  coupling::Window window{.step = 1, .time = 0.0, .interval = 1e-3, .saved = true};
  fluid.save();
  const auto before = fluid.state().particles.position;
  std::raise(SIGTERM);
  EXPECT_THROW(fluid.advance(window, {}), coupling::WindowGivenUp);
  fluid.restore();
  EXPECT_EQ(fluid.state().time, 0.0);
  EXPECT_EQ(fluid.state().particles.position, before);
  window.saved = false;
  EXPECT_TRUE(fluid.advance(window, {}).accepted);
  const coupling::InterruptGuard forgets;  // the signal
}

TEST(FreeWater, DamBreakKeepsItsEnergy) {
  const auto scene = tank(0.02, 1.6);
  Fluid<2> fluid(scene);
  fluid.initialise({});
  const double before = energy(fluid);
  double time = 0.0;
  run_to(fluid, time, 0.3);
  EXPECT_NEAR(energy(fluid) / before, 1.0, 0.1);
  double tip = 0.0;
  for (const auto& x : fluid.state().particles.position) tip = std::max(tip, x.x());
  EXPECT_GT(tip, 0.7);
  EXPECT_LT(tip, 0.4 + 2.0 * std::sqrt(9.81 * 0.2) * 0.3 + 0.02);  // Ritter's solution is an upper bound for the tip
}

// Water at the walls of a tank, in windows of a sixth and a sixtieth of the length that it proposes. Aggregates
// represent the smooth part of the pressure: 7 and 8 iterations per window, against 18 with the diagonal alone, and
// with multigrid.
TEST(FreeWater, ItsSolvesTakeFewIterationsAtAnySize) {
  for (const double dx : {0.005, 0.0025}) {
    Fluid<2> fluid(tank(dx, 2.0, 0.2));
    fluid.initialise({});
    double time = 0.0;
    run_to(fluid, time, 0.02);
    const auto counters = fluid.counters();
    EXPECT_EQ(counters.at("multigrid cycles"), 0.0) << dx;
    EXPECT_LT(counters.at("pressure iterations"), 12.0 * counters.at("windows")) << dx;
  }
}

TEST(FreeWater, ShortWindowsFeedItNoEnergy) {
  for (const double interval : {1e-3, 1e-4}) {
    Fluid<2> fluid(tank(0.02, 0.8));
    fluid.initialise({});
    const double start = energy(fluid);
    double time = 0.0;
    for (const double end : {0.3, 0.6, 0.9, 1.2}) {
      run_to(fluid, time, end, interval);
      EXPECT_LT(energy(fluid), start) << time << " s in windows of " << interval << " s";
    }
  }
}

// At half a spacing beyond the foremost particle, a wedge would end 0.83 spacings early, averaged over its positions.
TEST(FreeWater, AWedgeReachesAsFarAsItsTip) {
  Case scene = tank(0.02, 2.0);
  scene.gauges = {gauge("extent", "extent", {Point3(0.0, 0.0, 0.0), Point3(2.0, 0.0, 0.0)})};
  double error = 0.0;
  for (int i = 0; i < 20; ++i) {
    const double length = 1.0 + 0.003 * i;
    Shape wedge;
    wedge.kind = Shape::Kind::polygon;
    wedge.points = {Point3(0.0, 0.0, 0.0), Point3(length, 0.0, 0.0), Point3(0.0, 0.6 * length, 0.0)};
    scene.fluid.regions = {wedge};
    error += (reading(Fluid<2>(scene), "extent") - length) / 20.0;
  }
  EXPECT_NEAR(error, 0.0, 0.01);  // half a spacing; 0.4 measured
  scene.fluid.regions = {box(0.0, 0.0, 1.0, 0.6)};
  EXPECT_NEAR(reading(Fluid<2>(scene), "extent"), 1.0, 0.004);
}

// The sums over pairs are the kernel's moment times the second derivatives: 0.974 on a lattice.
TEST(FreeWater, VorticesDecayAtTheRateOfTheViscosity) {
  constexpr double interval = 1e-6;  // s, so short that nothing moves
  const auto energy_after_a_window = [](double jitter, double viscosity) {
    Case scene;
    scene.general.gravity.setZero();
    scene.general.domain_max = Point3(1.0, 1.0, 0.0);
    scene.general.periodic = {0, 1};
    scene.solid.model = SolidCase::Model::rigid;
    scene.water.kinematic_viscosity = viscosity;
    scene.fluid.particle_spacing = 0.02;
    scene.fluid.regions = {box(0.0, 0.0, 1.0, 1.0)};
    scene.fluid.initial_vortices = 0.01;
    scene.fluid.jitter = jitter;
    scene.gauges = {gauge("energy", "kinetic_energy")};
    Fluid<2> fluid(scene);
    fluid.initialise({});
    fluid.advance({0, 0.0, interval}, {});
    return reading(fluid, "energy");
  };
  for (const double jitter : {0.0, 0.1, 0.2}) {
    // Disordered points lose energy to the projection, too, with viscosity and without.
    const double lost = std::log(energy_after_a_window(jitter, 0.0) / energy_after_a_window(jitter, 1.0));
    EXPECT_NEAR(lost / interval, 16.0 * std::numbers::pi * std::numbers::pi, 0.8) << jitter;  // 0.5 %
  }
}

// Drops of one, four and nine particles: only gravity acts.
TEST(FreeWater, DropsFallFreely) {
  for (const double size : {0.02, 0.04, 0.06}) {
    Case scene = tank(0.02, 2.0);
    scene.fluid.regions = {box(1.0, 0.5, 1.0 + size, 0.5 + size)};
    scene.fluid.initial_velocity = Point3(0.5, 1.0, 0.0);
    Fluid<2> fluid(scene);
    fluid.initialise({});
    double time = 0.0;
    run_to(fluid, time, 0.3, 2e-3);
    const auto& p = fluid.state().particles;
    Vec<2> place = Vec<2>::Zero();
    for (std::size_t a = 0; a < p.size(); ++a) {
      place += p.position[a] / static_cast<double>(p.size());
      EXPECT_NEAR((p.velocity[a] - Vec<2>(0.5, 1.0 - 9.81 * time)).norm(), 0.0, 1e-3) << size;
    }
    const Vec<2> exact(1.0 + 0.5 * size + 0.5 * time, 0.5 + 0.5 * size + time - 0.5 * 9.81 * time * time);
    EXPECT_NEAR((place - exact).norm(), 0.0, 1e-4) << size;
  }
}

TEST(FreeWater, SlidingOverSoilItLosesEnergy) {
  // A shallow layer over saturated sand, fast and disordered, with loose particles: nothing throws them off the bed.
  for (const unsigned seed : {1u, 2u}) {
    Case scene;
    scene.solid.model = SolidCase::Model::rigid;
    scene.general.periodic = {0};
    scene.general.domain_max = Point3(0.4, 0.5, 0.0);
    scene.fluid.particle_spacing = 0.01;
    scene.fluid.jitter = 0.2;
    scene.fluid.seed = seed;
    scene.fluid.initial_velocity = Point3(2.0, 0.0, 0.0);
    scene.fluid.regions = {box(0.0, 0.0, 0.4, 0.09)};
    scene.soils = {sand()};
    scene.soils[0].hydraulic_conductivity = 1e-3;
    scene.soils[0].shape = box(0.0, 0.0, 0.4, 0.06);
    scene.walls = {wall(line(0.0, 0.0, 0.4, 0.0))};
    Fluid<2> fluid(scene);
    fluid.initialise({});
    double time = 0.0, before = energy(fluid);
    for (const double end : {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8}) {
      run_to(fluid, time, end);
      EXPECT_LT(energy(fluid), before) << time << " s, seed " << seed;
      before = energy(fluid);
    }
  }
}

TEST(FreeWater, ThreeDimensionsDarcyBetweenPlanes) {
  Case scene;
  scene.general.dimension = 3;
  scene.general.gravity = Point3(0.0, 0.0, -9.81);
  scene.general.domain_max = Point3(0.2, 0.08, 0.08);
  scene.general.periodic = {1};
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = 0.02;
  Shape block;
  block.max = Point3(0.2, 0.08, 0.08);
  scene.fluid.regions = {block};
  Soil soil;
  soil.shape = block;
  scene.soils = {soil};
  const auto plane = [](Point3 point, Point3 normal) {
    Face face;
    face.point = point;
    face.normal = normal;
    return face;
  };
  scene.walls = {wall(plane({0, 0, 0}, {0, 0, 1})), wall(plane({0, 0, 0.08}, {0, 0, -1}))};
  scene.water_faces = {head_face(plane({0, 0, 0}, {1, 0, 0}), 0.2), head_face(plane({0.2, 0, 0}, {-1, 0, 0}), 0.15)};
  Fluid<3> fluid(scene);
  fluid.initialise({});
  const double exact = 1e-4 * 0.25 / 0.4;
  for (std::uint64_t step = 0; step < 3; ++step) fluid.advance({step, 0.1 * static_cast<double>(step), 0.1}, {});
  ASSERT_EQ(fluid.state().particles.size(), 160u);
  for (const auto& v : fluid.state().particles.velocity) {
    EXPECT_NEAR(v.x() / exact, 1.0, 0.01);
    EXPECT_NEAR(v.tail<2>().norm() / exact, 0.0, 0.01);
  }
}

TEST(FreeWater, ASolveThatLeavesTooMuchPutsTheResultInDoubt) {
  Counts counts;
  const auto in_doubt = [&] {
    const auto warnings = warnings_of(counts);
    return std::ranges::any_of(warnings, [](const Warning& w) { return w.count > 0.0 && w.result_in_doubt; });
  };
  counts.unconverged = 3.0;
  EXPECT_FALSE(in_doubt());
  counts.in_doubt = 1.0;
  EXPECT_TRUE(in_doubt());
}

}  // namespace
}  // namespace poretwin::fluid
