// A scene and its copy at another size, scaled by Froude's law (time with the square root of length; conductivity,
// stiffness, cohesion, viscosity and pressures accordingly), give the same numbers. A difference would come from an
// absolute number in the code. Sizes are powers of sixteen, so that square roots are exact and rounding is the same.
#include "common/geometry/shapes.hpp"
#include "tests/fluid/both_solvers.hpp"
#include "tests/fluid/scenes.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace poretwin::fluid {
namespace {

using namespace test;

/// The case with all lengths multiplied by `length`.
Case scaled(Case scene, double length) {
  const double time = std::sqrt(length), speed = time;
  const auto shape = [&](Shape& s) {
    s.min *= length;
    s.max *= length;
    for (auto& x : s.points) x *= length;
    s.centre *= length;
    s.radius *= length;
  };
  const auto face = [&](Face& f) {
    for (auto& x : f.points) x *= length;
    f.point *= length;
  };
  const auto series = [&](std::optional<Series>& s, double value) {
    if (!s) return;
    for (auto& knot : s->knots) knot = {time * knot.first, value * knot.second};
  };
  scene.general.end_time *= time;
  scene.water.kinematic_viscosity *= length * speed;
  scene.water.cavitation_pressure *= length;
  for (auto& soil : scene.soils) {
    shape(soil.shape);
    soil.hydraulic_conductivity *= speed;
    soil.youngs_modulus *= length;
    soil.cohesion *= length;
    soil.suction_head *= length;
  }
  for (auto& w : scene.walls) face(w.face);
  for (auto& w : scene.water_faces) {
    face(w.face);
    series(w.head, length);
    series(w.pressure, length);
  }
  for (auto& load : scene.loads) {
    face(load.face);
    load.traction *= length;
    if (load.start) *load.start *= time;
    series(load.factor, 1.0);
  }
  scene.fluid.particle_spacing *= length;
  scene.solid.particle_spacing *= length;
  for (auto& region : scene.fluid.regions) shape(region);
  return scene;
}

/// Results of a run, relative to its size.
struct Numbers {
  double windows = 0.0;
  std::vector<double> values;
};

/// Positions, velocities and pressures of the water, over depth, sqrt(g depth) and rho g depth of about 0.1 m.
void add(Numbers& to, const Fluid<2>& fluid, double length) {
  const auto& p = fluid.state().particles;
  for (std::size_t a = 0; a < p.size(); ++a)
    for (int d = 0; d < 2; ++d) {
      to.values.push_back(p.position[a][d] / (0.1 * length));
      to.values.push_back(p.velocity[a][d] / std::sqrt(length));
      to.values.push_back(p.pressure[a] / (1000.0 * length));
    }
}

Numbers run_alone(const Case& scene, double length, double end) {
  Fluid<2> fluid(scaled(scene, length));
  fluid.initialise({});
  double time = 0.0;
  Numbers numbers;
  numbers.windows = static_cast<double>(run_to(fluid, time, end * std::sqrt(length)));
  add(numbers, fluid, length);
  return numbers;
}

Numbers run_coupled(const Case& scene, double length) {
  const Case mine = scaled(scene, length);
  BothSolvers both(mine);
  both.run_to_end();
  Numbers numbers;
  numbers.windows = static_cast<double>(both.run.report.windows);
  add(numbers, both.fluid, length);
  for (const double x : both.soil->publish().points.position) numbers.values.push_back(x / (0.1 * length));
  return numbers;
}

template <class Run>
void expect_same_at_all_sizes(const Run& run) {
  const Numbers one = run(1.0);
  EXPECT_GT(one.windows, 10.0);
  for (const double length : {1.0 / 4096.0, 4096.0}) {
    const Numbers other = run(length);
    EXPECT_EQ(other.windows, one.windows) << length;
    ASSERT_EQ(other.values.size(), one.values.size()) << length;
    double worst = 0.0;
    for (std::size_t i = 0; i < one.values.size(); ++i)
      worst = std::max(worst, std::abs(other.values[i] - one.values[i]));
    EXPECT_LT(worst, 1e-6) << length;
  }
}

Case tank(double width, double depth) {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = 0.0125;
  scene.fluid.regions = {box(0.0, 0.0, width, depth)};
  scene.walls = {wall(line(0.0, 0.4, 0.0, 0.0)), wall(line(0.0, 0.0, 0.3, 0.0)), wall(line(0.3, 0.0, 0.3, 0.4))};
  return scene;
}

TEST(Similarity, ATankAtRest) {
  expect_same_at_all_sizes([](double length) { return run_alone(tank(0.3, 0.1), length, 0.2); });
}

// No longer: splashes double a difference every few milliseconds, so that the last digit would become 2e-6 at 0.3 s.
TEST(Similarity, ADamBreak) {
  expect_same_at_all_sizes([](double length) { return run_alone(tank(0.1, 0.2), length, 0.1); });
}

/// Water enters dry soil with suction from a face of steady pressure; then the pressure rises.
TEST(Similarity, SeepageFromAPressureFace) {
  Case scene = ponded_column(0.02);
  scene.gauges.clear();
  scene.soils[0].suction_head = 0.05;
  scene.water_faces = {pressure_face(line(0.1, 0.4, 0.0, 0.4), 981.0)};
  scene.water_faces[0].pressure->knots = {{0.0, 981.0}, {200.0, 981.0}, {300.0, 2943.0}};
  expect_same_at_all_sizes([&](double length) { return run_alone(scene, length, 600.0); });
}

/// Two reservoirs of different level with sand and, beside it, free water: tests the initial pressure.
TEST(Similarity, SeepageBesideFreeWater) {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = 0.02;
  scene.soils = {sand()};
  scene.soils[0].hydraulic_conductivity = 1e-2;
  scene.soils[0].shape = box(0.2, 0.0, 0.4, 0.2);
  scene.fluid.regions = {box(0.0, 0.0, 0.4, 0.2)};
  scene.walls = {wall(line(0.0, 0.0, 0.4, 0.0)), wall(line(0.4, 0.2, 0.0, 0.2))};
  scene.water_faces = {head_face(line(0.0, 0.2, 0.0, 0.0), 0.4), head_face(line(0.4, 0.0, 0.4, 0.2), 0.3)};
  expect_same_at_all_sizes([&](double length) { return run_alone(scene, length, 0.2); });
}

/// A saturated column on a fixed base, drained at the top; a load begins, and later grows.
Case loaded_column(SolidCase::Model model) {
  Case scene;
  Soil soil = sand();
  soil.shape = box(0.0, 0.0, 0.1, 0.2);
  soil.cohesion = 500.0;
  scene.soils = {soil};
  scene.solid.model = model;
  scene.solid.particle_spacing = scene.fluid.particle_spacing = 0.02;
  scene.fluid.regions = {soil.shape};
  scene.walls = {wall(line(0.0, 0.2, 0.0, 0.0)), wall(line(0.0, 0.0, 0.1, 0.0)), wall(line(0.1, 0.0, 0.1, 0.2))};
  scene.walls[1].soil = Wall::ForSoil::fixed;
  scene.water_faces = {pressure_face(line(0.1, 0.2, 0.0, 0.2), 0.0)};
  Load load;
  load.face = line(0.1, 0.2, 0.0, 0.2);
  load.traction = Point3(0.0, -1000.0, 0.0);
  load.start = 0.05;
  load.factor = Series{{{0.0, 1.0}, {0.2, 1.0}, {0.4, 2.0}}};
  scene.loads = {load};
  scene.general.end_time = 1.0;
  return scene;
}

TEST(Similarity, AnElasticColumnUnderLoad) {
  const Case scene = loaded_column(SolidCase::Model::elastic);
  expect_same_at_all_sizes([&](double length) { return run_coupled(scene, length); });
}

TEST(Similarity, AColumnThatMayYieldUnderLoad) {
  const Case scene = loaded_column(SolidCase::Model::drucker_prager);
  expect_same_at_all_sizes([&](double length) { return run_coupled(scene, length); });
}

/// Terzaghi: clay with k = 1e-9 m/s and E = 1e6 Pa under 200 Pa (his theory assumes small strains, and a face does not
/// move with elastic soil that sinks away from it), drained at the top only, 5 m thick, over 27 years. Degree of
/// consolidation U = 1 - sum 2 / M^2 exp(-M^2 T), M = pi (m + 1/2), T = k E t / (gamma_w H^2).
TEST(Similarity, ClayConsolidatesForYearsInFewWindows) {
  const double height = 5.0, end = 8.64e8, load = 200.0, modulus = 1e6, k = 1e-9;
  Case scene;
  Soil clay = sand();
  clay.shape = box(0.0, 0.0, 1.0, height);
  clay.hydraulic_conductivity = k;
  clay.youngs_modulus = modulus;
  clay.poissons_ratio = 0.0;
  scene.soils = {clay};
  scene.general.gravity.setZero();
  scene.general.end_time = end;
  scene.solid.particle_spacing = scene.fluid.particle_spacing = 0.25;
  scene.fluid.regions = {clay.shape};
  scene.walls = {wall(line(0.0, height, 0.0, 0.0)), wall(line(0.0, 0.0, 1.0, 0.0)), wall(line(1.0, 0.0, 1.0, height))};
  scene.walls[1].soil = Wall::ForSoil::fixed;
  scene.water_faces = {pressure_face(line(1.0, height, 0.0, height), 0.0)};
  Load fill;
  fill.face = line(1.0, height, 0.0, height);
  fill.traction = Point3(0.0, -load, 0.0);
  fill.start = 0.0;
  scene.loads = {fill};
  Gauge top = gauge("settlement", "point", {Point3(0.5, height, 0.0)}, "displacement_y");
  top.phase = "solid";
  scene.gauges = {top};
  BothSolvers both(scene);
  coupling::CoupledRun& run = both.run;
  run.settings = {end, std::nullopt, 0.0, end / 40.0};
  run.stop_after = 301;
  both.run_to_end();
  EXPECT_FALSE(run.report.interrupted) << "at " << run.report.time << " s";
  double worst = 0.0;
  for (const auto& reading : run.solid_record.series) {
    const double T = k * modulus * reading.time / (9810.0 * height * height);
    double left = 0.0;
    for (int m = 0; m < 200; ++m) {
      const double M = std::numbers::pi * (m + 0.5);
      left += 2.0 / (M * M) * std::exp(-M * M * T);
    }
    if (T > 0.0)
      worst = std::max(worst, std::abs(-reading.readings[0].value * modulus / (load * height) - (1.0 - left)));
  }
  EXPECT_LT(worst, 0.01);
}

}  // namespace
}  // namespace poretwin::fluid
