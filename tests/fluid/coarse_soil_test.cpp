// Water in very coarse soil, where both inertia and drag matter.
#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/energy.hpp"
#include "tests/fluid/scenes.hpp"

#include <gtest/gtest.h>

namespace poretwin::fluid {
namespace {

using namespace test;

Soil gravel(double conductivity, Shape shape) {
  Soil soil = sand();
  soil.hydraulic_conductivity = conductivity;
  soil.shape = std::move(shape);
  return soil;
}

// A slab of water with air on both sides falls through the pores: v = (k/n) (1 - exp(-g n t/k)), without any pressure.
TEST(CoarseSoil, ASlabFallsAgainstItsDrag) {
  const double k = 1.0, rate = 9.81 * 0.4 / k;
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.general.periodic = {0};
  scene.general.domain_max = Point3(0.2, 2.0, 0.0);
  scene.fluid.particle_spacing = 0.01;
  scene.fluid.regions = {box(0.0, 1.5, 0.2, 1.6)};
  scene.soils = {gravel(k, box(0.0, 0.0, 0.2, 2.0))};
  scene.walls = {wall(line(0.0, 0.0, 0.2, 0.0))};
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  for (const double end : {0.05, 0.1, 0.2, 0.3}) {
    run_to(fluid, time, end);
    const double exact = 9.81 / rate * (1.0 - std::exp(-rate * time)), fallen = (9.81 * time - exact) / rate;
    const auto& p = fluid.state().particles;
    Vec<2> place = Vec<2>::Zero();
    for (std::size_t a = 0; a < p.size(); ++a) {
      place += p.position[a] / static_cast<double>(p.size());
      EXPECT_NEAR((p.velocity[a] + Vec<2>(0.0, exact)).norm() / exact, 0.0, 0.01) << time << " s";  // 0.006 measured
    }
    EXPECT_NEAR(1.55 - place.y(), fallen, 0.001);  // a tenth of a spacing; 0.0008 measured, from the first 0.05 s
  }
}

/// The limit of the last window whose reason begins with this text [s]; 0: none.
double told_limit(const Fluid<2>& fluid, const std::string& reason) {
  for (const auto& limit : fluid.state().window_limits)
    if (limit.reason.starts_with(reason)) return limit.interval;
  return 0.0;
}

// The slab, thrown downwards: at the speed v and acceleration a of the last window, the fastest particle moves by (v +
// a t) t = dx/4. No such limit: for water in sand, and for water so fast (C dx < n rho w, 0.04 m/s) that it counts as
// free.
TEST(CoarseSoil, WindowsEndAfterAQuarterSpacingOfAcceleratedWay) {
  for (const auto& [k, thrown] : {std::pair(1.0, 0.02), std::pair(1e-3, 0.02), std::pair(1.0, 0.5)}) {
    const double dx = 0.01, dt = 1e-4;
    Case scene;
    scene.solid.model = SolidCase::Model::rigid;
    scene.general.periodic = {0};
    scene.general.domain_max = Point3(0.2, 2.0, 0.0);
    scene.fluid.particle_spacing = dx;
    scene.fluid.regions = {box(0.0, 1.5, 0.2, 1.6)};
    scene.fluid.initial_velocity = Point3(0.0, -thrown, 0.0);
    scene.soils = {gravel(k, box(0.0, 0.0, 0.2, 2.0))};
    scene.walls = {wall(line(0.0, 0.0, 0.2, 0.0))};
    Fluid<2> fluid(scene);
    fluid.initialise({});
    fluid.advance({0, 0.0, dt}, {});
    const double limit = told_limit(fluid, "a quarter spacing per window of water in coarse soil");
    if (k < 0.01 || thrown > 0.04) {
      EXPECT_EQ(limit, 0.0);
      continue;
    }
    double farthest = 0.0;
    for (const auto& v : fluid.state().particles.velocity) {
      const double acceleration = (v + Vec<2>(0.0, thrown)).norm() / dt;
      EXPECT_NEAR(acceleration, 9.81, 2.0);
      farthest = std::max(farthest, (v.norm() + acceleration * limit) * limit);
    }
    EXPECT_NEAR(farthest, 0.25 * dx, 1e-9 * dx);
  }
}

// Windows end before the level behind a face has changed by half a spacing, whatever the soil: 5 mm at 0.1 m/s.
TEST(CoarseSoil, WindowsEndBeforeItsLevelIsHalfASpacingOff) {
  for (const double k : {0.1, 1e-4}) {
    Case scene = ponded_column(0.01);
    scene.soils[0].hydraulic_conductivity = k;
    scene.fluid.regions = {scene.soils[0].shape};
    scene.water_faces[0].head = Series{{{0.0, 0.4}, {10.0, 1.4}}};
    Fluid<2> fluid(scene);
    fluid.initialise({});
    const auto [limit, why] = fluid.proposal();
    EXPECT_NEAR(limit, 0.05, 1e-9);
    EXPECT_EQ(why, "a level that changes behind a face");
  }
}

// From sand to rockfill: water that plunges into soil and out of it gains no energy from the drag.
TEST(CoarseSoil, ADamBreakOverItLosesEnergy) {
  for (const double k : {0.01, 0.1, 1.0, 15.0}) {
    Case scene;
    scene.solid.model = SolidCase::Model::rigid;
    scene.fluid.particle_spacing = 0.02;
    scene.fluid.regions = {box(0.0, 0.0, 0.4, 0.6)};
    scene.soils = {gravel(k, box(0.0, 0.0, 1.6, 0.1))};
    scene.walls = {wall(line(0.0, 1.0, 0.0, 0.0)), wall(line(0.0, 0.0, 1.6, 0.0)), wall(line(1.6, 0.0, 1.6, 1.0))};
    Fluid<2> fluid(scene);
    fluid.initialise({});
    double time = 0.0, before = energy(fluid);
    for (int tenth = 1; tenth <= 10; ++tenth) {
      run_to(fluid, time, 0.1 * tenth);
      EXPECT_LT(energy(fluid), before) << time << " s, k = " << k;
      before = energy(fluid);
    }
  }
}

}  // namespace
}  // namespace poretwin::fluid
