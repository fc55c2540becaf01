// Water at rest and water seeping through rigid soil, against exact solutions.
#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/scenes.hpp"

#include <gtest/gtest.h>

namespace poretwin::fluid {
namespace {

using namespace test;

TEST(Seepage, TankAtRestStaysAtRest) {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = 0.02;
  scene.fluid.regions = {box(0.0, 0.0, 0.4, 0.2)};
  scene.walls = {wall(line(0.0, 0.4, 0.0, 0.0)), wall(line(0.0, 0.0, 0.4, 0.0)), wall(line(0.4, 0.0, 0.4, 0.4))};
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  run_to(fluid, time, 2.0);
  for (std::size_t a = 0; a < fluid.state().particles.size(); ++a) {
    const auto& p = fluid.state().particles;
    const double exact = 9810.0 * (0.2 - p.position[a].y());
    EXPECT_NEAR(p.pressure[a] + 9810.0 * (0.2 - p.position[a].y()), exact, 0.01 * 9810.0 * 0.2);
    EXPECT_LT(p.velocity[a].norm(), 1e-3);
  }
}

TEST(Seepage, ConfinedFlowObeysDarcy) {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = 0.02;
  scene.soils = {sand()};
  scene.soils[0].shape = box(0.0, 0.0, 0.4, 0.2);
  scene.fluid.regions = {box(0.0, 0.0, 0.4, 0.2)};
  scene.walls = {wall(line(0.0, 0.0, 0.4, 0.0)), wall(line(0.4, 0.2, 0.0, 0.2))};
  scene.water_faces = {head_face(line(0.0, 0.2, 0.0, 0.0), 0.4), head_face(line(0.4, 0.0, 0.4, 0.2), 0.3)};
  Fluid<2> fluid(scene);
  fluid.initialise({});
  const double exact = 1.1e-4 * 0.25 / 0.4;
  for (const double dt : {0.1, 1e-3, 8.0}) {
    fluid.advance({0, 0.0, dt}, {});
    const auto& p = fluid.state().particles;
    for (std::size_t a = 0; a < p.size(); ++a) {
      EXPECT_NEAR(p.velocity[a].x() / exact, 1.0, 0.01);
      EXPECT_NEAR(p.velocity[a].y() / exact, 0.0, 0.01);
    }
  }
  // Steady: as much born as deleted, still Darcy's velocity after two pore volumes.
  double time = 0.0;
  const std::size_t before = fluid.state().particles.size();
  run_to(fluid, time, 2.0 * 0.4 / exact);
  const auto& p = fluid.state().particles;
  EXPECT_NEAR(static_cast<double>(p.size()), static_cast<double>(before), 0.06 * static_cast<double>(before));
  double mean = 0.0;
  for (const auto& v : p.velocity) mean += v.x() / exact / static_cast<double>(p.size());
  EXPECT_NEAR(mean, 1.0, 0.02);
  RecordProperty("mean_velocity_over_exact", std::to_string(mean));
}

TEST(Seepage, SmoothedDragIsAsStrongAsItsKernelSum) {
  // Darcy flow along x under Eq. (74): slower than Darcy's by the kernel sum over the soil's lattice (independent sums
  // for h = 1.2; coincident lattices, cell centres, edges).
  using enum FluidCase::DragForm;
  struct Row {
    FluidCase::DragForm form;
    double shift_x, shift_y, factor;
  };
  for (const auto& row :
       {Row{pointwise, 0.0, 0.0, 1.0}, Row{smoothed, 0.0, 0.0, 2.0 * 0.3415652},
        Row{smoothed, 0.5, 0.5, 2.0 * 0.5006536}, Row{smoothed, 0.5, 0.0, 2.0 * 0.6692462},
        Row{smoothed, 0.0, 0.5, 2.0 * 0.3259724}, Row{smoothed_as_printed, 0.0, 0.0, 0.5 * 0.3415652}}) {
    Case scene;
    scene.solid.model = SolidCase::Model::rigid;
    scene.fluid.particle_spacing = scene.solid.particle_spacing = 0.02;
    scene.fluid.drag_form = row.form;
    scene.solid.offset = {0.5 + row.shift_x, 0.5 + row.shift_y, 0.0};
    scene.soils = {sand()};
    scene.soils[0].shape = box(-0.2, -0.2, 0.6, 0.4);  // no truncated sums at the ends
    scene.fluid.regions = {box(0.0, 0.0, 0.4, 0.2)};
    scene.walls = {wall(line(0.0, 0.0, 0.4, 0.0)), wall(line(0.4, 0.2, 0.0, 0.2))};
    scene.water_faces = {head_face(line(0.0, 0.2, 0.0, 0.0), 0.4), head_face(line(0.4, 0.0, 0.4, 0.2), 0.3)};
    Fluid<2> fluid(scene);
    fluid.initialise({});
    // The part that differs between directions is iterated, to 2 % in a window from rest: a few short windows
    // (particles that leave their sites by a hundredth of a spacing find another sum).
    for (std::uint64_t step = 0; step < 4; ++step) fluid.advance({step, 2e-3 * static_cast<double>(step), 2e-3}, {});
    const double exact = 1.1e-4 * 0.25 / 0.4 / row.factor;
    for (const auto& v : fluid.state().particles.velocity) {
      EXPECT_NEAR(v.x() / exact, 1.0, 0.01) << row.factor;
      EXPECT_NEAR(v.y() / exact, 0.0, 0.01) << row.factor;
    }
  }
}

TEST(Seepage, QuadraticFlowFromRestFollowsItsClosedForm) {
  // n rho dw/dt = n gamma i - (c1 + c2 w) w from rest: w = w+ (1 - e) / (1 - w+/w- e), e = exp(-c2 (w+ - w-) t / (n
  // rho)), w+ and w- the roots of the right side.
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = 0.02;
  Soil rock;
  rock.porosity = 0.4052;
  rock.seepage_law = Soil::SeepageLaw::ergun;
  rock.grain_diameter = 0.03504;
  rock.shape = box(0.0, 0.0, 0.4, 0.2);
  scene.soils = {rock};
  scene.fluid.regions = {box(0.0, 0.0, 0.4, 0.2)};
  scene.walls = {wall(line(0.0, 0.0, 0.4, 0.0)), wall(line(0.4, 0.2, 0.0, 0.2))};
  scene.water_faces = {head_face(line(0.0, 0.2, 0.0, 0.0), 0.4), head_face(line(0.4, 0.0, 0.4, 0.2), 0.3)};
  const double n = rock.porosity, i = 0.25, c1 = 9810.0 * n * n * 0.066226, c2 = 9810.0 * n * n * n * 45.516;
  const double root = std::sqrt(c1 * c1 + 4.0 * c2 * n * 9810.0 * i);
  const double up = (root - c1) / (2.0 * c2), down = -(root + c1) / (2.0 * c2);
  for (const double dt : {1e-3, 0.02}) {
    Fluid<2> fluid(scene);
    fluid.initialise({});
    double time = 0.0, worst = 0.0, spread = 0.0;
    const auto& p = fluid.state().particles;
    for (std::uint64_t step = 0; time < 1.0; ++step) {
      fluid.advance({step, time, dt}, {});
      time += dt;
      const double e = std::exp(-c2 * (up - down) * time / (n * 1000.0));
      const double exact = up * (1.0 - e) / (1.0 - up / down * e);
      double mean = 0.0;
      for (const auto& v : p.velocity) mean += v.x() / static_cast<double>(p.size());
      for (const auto& v : p.velocity) spread = std::max(spread, (v - Vec<2>(mean, 0.0)).norm() / up);
      worst = std::max(worst, std::abs(mean - exact) / up);
      if (time > 0.9) {
        EXPECT_NEAR(mean / up, 1.0, 0.003);
      }
    }
    std::printf("quadratic flow, window %.0e s: %.4f of the steady velocity off, spread %.4f, %g further rounds\n", dt,
                worst, spread, fluid.state().counts.drag_rounds);
    EXPECT_LT(worst, 8.0 * dt);
    EXPECT_LT(spread, 0.02);
  }
}

/// Dry soil without gravity, 25 mm high, into which water is pressed from the left under half a metre of water: its
/// front is at z = sqrt(2 k H t / n).
Case pressed_column(double dx) {
  Case scene;
  scene.general.gravity.setZero();
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = dx;
  scene.soils = {sand()};
  scene.soils[0].shape = box(0.0, 0.0, 0.4, 0.025);
  scene.walls = {wall(line(0.0, 0.0, 0.4, 0.0)), wall(line(0.4, 0.025, 0.0, 0.025))};
  scene.water_faces = {pressure_face(line(0.0, 0.025, 0.0, 0.0), 4905.0)};
  scene.gauges = front_and_volume(Point3(0.0, 0.0125, 0.0), Point3(0.4, 0.0125, 0.0));
  return scene;
}
double time_to(double z) { return 0.4 * z * z / (2.0 * 1.1e-4 * 4905.0 / 9810.0); }

TEST(Seepage, PondedWaterInfiltratesDryGround) {
  // Sharp front under a constant head H0: t = (n/k) [z - H0 ln(1 + z/H0)].
  const auto scene = ponded_column(0.01);
  Fluid<2> fluid(scene);
  EXPECT_EQ(fluid.publish().points.n_active, 0u);
  fluid.initialise({});
  double time = 0.0;
  for (const double z : {0.1, 0.2, 0.3}) {
    const double t = 0.4 / 1.1e-4 * (z - 0.1 * std::log(1.0 + z / 0.1));
    run_to(fluid, time, t);
    const double front = reading(fluid, "front"), volume = reading(fluid, "volume");
    EXPECT_NEAR(front / z, 1.0, 0.02);
    EXPECT_NEAR(volume / (0.4 * 0.1 * z), 1.0, 0.03);
    std::printf("z %.3f front %.5f (%+.2f %%) volume %+.2f %%  particles %zu\n", z, front, 100 * (front / z - 1),
                100 * (volume / (0.04 * z) - 1), fluid.state().particles.size());
  }
  for (const auto& [name, value] : fluid.counters()) std::printf("  %s %g\n", name.c_str(), value);
}

TEST(Seepage, WaterPressedIntoDrySoilKeepsItsPacking) {
  // Two rows between walls, too: there all particles have one pressure at first.
  for (const double dx : {0.0125, 0.00625, 0.0025}) {
    const auto scene = pressed_column(dx);
    Fluid<2> fluid(scene);
    fluid.initialise({});
    double time = 0.0;
    for (const double z : {0.05, 0.1}) {
      run_to(fluid, time, time_to(z));
      const double ahead = reading(fluid, "front") / z - 1.0, more = reading(fluid, "volume") / (0.01 * z) - 1.0;
      std::printf("spacing %g m, depth %g m: front %+.4f, volume %+.4f\n", dx, z, ahead, more);
      EXPECT_LT(std::abs(ahead), 0.003);
      EXPECT_LT(std::abs(more), 0.01);
    }
  }
}

TEST(Seepage, AFrontIsRightFromItsFirstSpacingOn) {
  // One row of particles, then two: in short windows hardly anything is left of the error.
  const double dx = 0.0125;
  const auto scene = pressed_column(dx);
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  for (const double z : {1.0 * dx, 1.5 * dx, 2.0 * dx}) {
    run_to(fluid, time, time_to(z), 0.01);
    EXPECT_NEAR(reading(fluid, "volume") / (0.01 * z), 1.0, 1e-3) << z / dx;
  }
}

TEST(Seepage, WaterEndsAtASeepageFace) {
  // Level flow to a face without water behind it, where rows of particles go out one by one: Darcy over the full
  // length.
  auto scene = pressed_column(0.0125);
  scene.soils[0].shape = box(0.0, 0.0, 0.3, 0.1);
  scene.fluid.regions = {scene.soils[0].shape};
  scene.walls = {wall(line(0.0, 0.0, 0.3, 0.0)), wall(line(0.3, 0.1, 0.0, 0.1))};
  scene.water_faces = {pressure_face(line(0.0, 0.1, 0.0, 0.0), 2943.0), pressure_face(line(0.3, 0.0, 0.3, 0.1), -1.0)};
  scene.water_faces[0].name = "in";
  Gauge in;
  in.name = in.kind = "passed_volume";
  in.phase = "fluid";
  in.quantity = "in";
  scene.gauges = {in};
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  run_to(fluid, time, 1000.0);
  const double before = reading(fluid, "passed_volume");
  run_to(fluid, time, 3000.0);
  EXPECT_NEAR((reading(fluid, "passed_volume") - before) / 2000.0 / 1.1e-5, 1.0, 1e-3);
}

TEST(Seepage, RestoredStateRepeatsItself) {
  const auto scene = ponded_column(0.02);
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0;
  run_to(fluid, time, 50.0);
  fluid.save();
  const double start = time;
  run_to(fluid, time, 150.0);
  const auto first = fluid.state();
  fluid.restore();
  time = start;
  run_to(fluid, time, 150.0);
  const auto& second = fluid.state();
  ASSERT_EQ(first.particles.size(), second.particles.size());
  EXPECT_GT(first.particles.size(), 10u);
  for (std::size_t a = 0; a < first.particles.size(); ++a) {
    EXPECT_EQ(first.particles.position[a], second.particles.position[a]);
    EXPECT_EQ(first.particles.velocity[a], second.particles.velocity[a]);
    EXPECT_EQ(first.particles.pressure[a], second.particles.pressure[a]);
  }
}

TEST(Seepage, WaterPastASeepageFaceIsInTheAir) {
  // Water drains out of an embankment whose steep face has nothing behind it; what it pushes out stays as far as a
  // quarter of a spacing for a while, and its pressure is not the slope inside carried on.
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = 0.01;
  scene.soils = {sand()};
  scene.soils[0].shape = box(0.0, 0.0, 0.2, 0.12);
  scene.fluid.regions = {box(0.0, 0.0, 0.2, 0.1)};
  scene.walls = {wall(line(0.0, 0.12, 0.0, 0.0)), wall(line(0.0, 0.0, 0.2, 0.0))};
  scene.water_faces = {head_face(line(0.2, 0.0, 0.2, 0.12), 0.0)};
  Fluid<2> fluid(scene);
  fluid.initialise({});
  double time = 0.0, top = 0.0;
  {
    const auto& p = fluid.state().particles;  // at rest: piezometric pressure 0 at the top, total p = rho g depth
    for (const auto& x : p.position) top = std::max(top, x.y() + 0.005);
  }
  int outside = 0;
  for (int window = 0; window < 60; ++window) {
    run_to(fluid, time, time + 2.0);
    const auto& p = fluid.state().particles;
    for (std::size_t a = 0; a < p.size(); ++a)
      if (p.position[a].x() > 0.2) {
        ++outside;
        EXPECT_GE(p.pressure[a] + 9810.0 * (top - p.position[a].y()), -1e-9) << time;
      }
  }
  EXPECT_GT(outside, 20);
}

TEST(Seepage, NoWaterAtAllIsNoProblem) {
  auto scene = ponded_column(0.02);
  scene.water_faces[0].head = constant(0.1);  // below the face: dry for ever
  Fluid<2> fluid(scene);
  fluid.initialise({});
  for (int i = 0; i < 3; ++i) fluid.advance({static_cast<std::uint64_t>(i), 1.0 * i, 1.0}, {});
  EXPECT_EQ(fluid.state().particles.size(), 0u);
  EXPECT_EQ(fluid.publish().points.size(), 0u);
  EXPECT_EQ(reading(fluid, "front"), 0.0);
  EXPECT_EQ(reading(fluid, "volume"), 0.0);
  EXPECT_TRUE(fluid.frame().position.empty());
}

}  // namespace
}  // namespace poretwin::fluid
