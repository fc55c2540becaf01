// Explicit incompressible SPH: a sweep, the windows that it needs, and its results.
#include "fluid_solver/pressure/eisph.hpp"
#include "common/core/error.hpp"
#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/scenes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace poretwin::fluid {
namespace {

using namespace test;
using Scheme = FluidCase::Scheme;

Case tank(double dx) {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = dx;
  scene.fluid.scheme = Scheme::eisph;
  scene.fluid.regions = {box(0.0, 0.0, 0.4, 0.2)};
  scene.walls = {wall(line(0.0, 1.0, 0.0, 0.0)), wall(line(0.0, 0.0, 0.4, 0.0)), wall(line(0.4, 0.0, 0.4, 1.0))};
  return scene;
}

/// Water that moves in soil, in a periodic box; only the drag acts.
Case drifting_water(double conductivity) {
  Case scene;
  scene.general.gravity.setZero();
  scene.general.domain_max = Point3(0.2, 0.2, 0.0);
  scene.general.periodic = {0, 1};
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = 0.02;
  scene.fluid.regions = {box(0.0, 0.0, 0.2, 0.2)};
  scene.fluid.initial_velocity = Point3(0.01, 0.0, 0.0);
  Soil soil;
  soil.shape = scene.fluid.regions[0];
  soil.porosity = 0.4;
  soil.hydraulic_conductivity = conductivity;
  scene.soils = {soil};
  return scene;
}

/// Root-mean-square pressure error over rho g H; `speed`: of the fastest particle.
double unrest(const Fluid<2>& fluid, double& speed) {
  const auto& p = fluid.state().particles;
  double error = 0.0;
  speed = 0.0;
  for (std::size_t a = 0; a < p.size(); ++a) {
    error += p.pressure[a] * p.pressure[a] / static_cast<double>(p.size());
    speed = std::max(speed, p.velocity[a].norm());
  }
  return std::sqrt(error) / (9810.0 * 0.2);
}

TEST(Eisph, SweepsTendToTheSolution) {
  // A chain of three between fixed ends: p = 1, 2, 3.
  const std::vector<Index> offset{0, 4, 8, 12}, neighbour{1, 0, 0, 0, 0, 2, 1, 1, 1, 2, 2, 2};
  PairMatrix A;
  A.column = {offset, neighbour, {}, {}};
  A.weight = {1, 0, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0};
  A.diagonal = {2, 2, 2};
  const ScalarArray b{0.0, 0.0, 4.0};
  ScalarArray p(3, 0.0);
  const ScalarArray relaxation(3, pressure::sweep_relaxation);
  relaxed_sweeps(A, b, relaxation, p, 1);
  EXPECT_DOUBLE_EQ(p[2], pressure::sweep_relaxation * 2.0);
  EXPECT_DOUBLE_EQ(p[0], 0.0);
  relaxed_sweeps(A, b, relaxation, p, 200);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(p[static_cast<std::size_t>(i)], i + 1.0, 1e-9);
}

TEST(Eisph, WindowsFollowFromTheCompressionOfASweep) {
  // Free water: quadratic in the spacing; drag-dominated soil: linear in spacing^2, drag and number of sweeps.
  const auto free = [](double dx, int sweeps) { return sweep_interval<2>(1.0, 0.0, 1000.0, 2000.0, dx, sweeps); };
  const auto soil = [](double dx, int sweeps) { return sweep_interval<2>(0.4, 1e7, 1000.0, 2000.0, dx, sweeps); };
  EXPECT_NEAR(free(0.02, 1) / free(0.01, 1), 2.0, 1e-9);
  EXPECT_NEAR(free(0.01, 4) / free(0.01, 1), 2.0, 1e-9);
  EXPECT_NEAR(soil(0.02, 1) / soil(0.01, 1), 4.0, 1e-2);
  EXPECT_NEAR(soil(0.01, 4) / soil(0.01, 1), 4.0, 1e-2);
  // One spacing per window is the speed of sound, at least ten times sqrt(p/rho).
  EXPECT_GT(0.01 / free(0.01, 1), 10.0 * std::sqrt(2000.0 / 1000.0));

  // In a window of a tenth of the length water has the same stiffness: the relaxation goes with dt^2, in soil with dt.
  EXPECT_DOUBLE_EQ(relaxation_in(1.0, 1e6, 0.0), pressure::sweep_relaxation);
  EXPECT_NEAR(relaxation_in(0.1, 1e6, 0.0) / pressure::sweep_relaxation, 0.01, 1e-12);
  EXPECT_NEAR(relaxation_in(0.1, 1e6, 1e10) / pressure::sweep_relaxation, 0.1, 1e-4);

  Fluid<2> fluid(tank(0.02));
  fluid.initialise({});
  EXPECT_EQ(fluid.publish().limited_by, "compression under explicit sweeps");
  EXPECT_NEAR(fluid.publish().proposed_interval, sweep_interval<2>(1.0, 0.0, 1000.0, 9810.0 * 0.19, 0.02, 1), 1e-9);
}

TEST(Eisph, SweepsTrustADivergenceWhereThePressureAnswersIt) {
  // A lattice without a surface: its middle is inside; its edge has all neighbours on one side.
  VecArray<2> x;
  for (int i = -4; i <= 4; ++i)
    for (int j = -4; j <= 4; ++j) x.push_back({0.1 * i, 0.1 * j});
  const ScalarArray volume(x.size(), 0.01);
  auto s = make_stencil<2>(x, volume, {}, {});
  EXPECT_EQ(sweep_trust(s, 40), 1.0);
  EXPECT_EQ(sweep_trust(s, 4), 0.0);
  // The ghost of the free surface reverses its own part.
  s.ghost_distance.set(4, 0.05, s.n_real);
  EXPECT_EQ(sweep_trust(s, 4), 1.0);
}

TEST(Eisph, ADamBreakGainsNoEnergy) {
  // Where the column is stretched, inner particles have few neighbours on one side. Without sweep_trust energy grows
  // from 0.5 s on, and the run diverges at 0.65 s. Each fiftieth of a second ends with a very short window.
  auto scene = tank(0.08);
  scene.fluid.regions = {box(0.0, 0.0, 1.0, 2.0)};
  scene.walls = {wall(line(0.0, 6.0, 0.0, 0.0)), wall(line(0.0, 0.0, 4.0, 0.0)), wall(line(4.0, 0.0, 4.0, 6.0))};
  Fluid<2> fluid(scene);
  fluid.initialise({});
  const auto energy = [&] {
    const auto& p = fluid.state().particles;
    double sum = 0.0;
    for (std::size_t a = 0; a < p.size(); ++a)
      sum += p.mass[a] * (0.5 * p.velocity[a].squaredNorm() + 9.81 * p.position[a].y());
    return sum;
  };
  const double released = 14715.0;  // J: 2 m2 of water, from 1 m to 0.25 m on average
  double time = 0.0, least = energy();
  for (int i = 1; i <= 40; ++i) {
    run_to(fluid, time, 0.02 * i);
    EXPECT_LT(energy() - least, 0.005 * released) << time;
    least = std::min(least, energy());
  }
}

TEST(Eisph, LatticeAtRestStaysAtRest) {
  Fluid<2> fluid(tank(0.02));
  fluid.initialise({});
  double time = 0.0, speed = 0.0;
  run_to(fluid, time, 1.0);
  EXPECT_LT(unrest(fluid, speed), 1e-9);
  EXPECT_LT(speed, 1e-9);
}

TEST(Eisph, DisorderedTankStaysQuiet) {
  auto scene = tank(0.02);
  scene.fluid.jitter = 0.2;
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0, speed = 0.0;
  run_to(fluid, time, 3.0);
  EXPECT_LT(unrest(fluid, speed), 0.02);
  EXPECT_LT(speed, 0.014);  // 1 % of sqrt(g H)
}

TEST(Eisph, PondedWaterInfiltratesDryGround) {
  Case scene = ponded_column(0.02);
  scene.fluid.scheme = Scheme::eisph;
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  for (const double z : {0.1, 0.2, 0.3}) {
    run_to(fluid, time, 0.4 / 1.1e-4 * (z - 0.1 * std::log(1.0 + z / 0.1)));
    EXPECT_NEAR(reading(fluid, "front") / z, 1.0, 0.01);
  }
}

TEST(Eisph, ExplicitDragNeedsItsRateResolved) {
  // Water in soil decelerates at the rate beta = g n/k; the required limit is beta dt = 1.
  const double beta = 9.81 * 0.4 / 1e-2;
  for (const auto scheme : {Scheme::eisph, Scheme::eisph_explicit_drag}) {
    Case scene = drifting_water(1e-2);
    scene.fluid.scheme = scheme;
    Fluid<2> fluid(scene);
    fluid.initialise({});
    const bool limited = scheme == Scheme::eisph_explicit_drag;
    EXPECT_EQ(fluid.publish().limited_by == "explicit drag", limited) << fluid.publish().limited_by;
    if (limited) {
      EXPECT_NEAR(fluid.publish().proposed_interval * beta, 1.0, 1e-9);
    }
    double time = 0.0;
    run_to(fluid, time, 1.0 / beta, 0.01 / beta);
    for (const auto& v : fluid.state().particles.velocity) EXPECT_NEAR(v.x() / 0.01, std::exp(-1.0), 2e-3);
  }
}

TEST(Eisph, DivergenceNamesParticleTermAndLastGoodState) {
  // Explicit drag at beta dt = 3.6: each window reverses the velocity and makes it 2.6 times as large.
  Case scene = drifting_water(1.1e-4);
  scene.fluid.scheme = Scheme::eisph_explicit_drag;
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  try {
    for (std::uint64_t i = 0; i < 400; ++i, time += 1e-4) fluid.advance({i, time, 1e-4}, {});
    ADD_FAILURE() << "did not diverge";
  } catch (const DivergedError& error) {
    EXPECT_THAT(error.what(), testing::ContainsRegex("(pore_pressure|velocity).* of particle [0-9]+ at \\(.*\\).*; "
                                                     "last good state at t = [0-9.e-]+ s"));
  }
}

}  // namespace
}  // namespace poretwin::fluid
