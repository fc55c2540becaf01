// Water on two ranks moves as on one. Each rank has a body of water of its own, out of the other's reach, so that no
// values pass between them: what differs from one rank was decided by one rank alone. Water that crosses from rank to
// rank, and faces through which it passes: tests/tiles.
#include "tests/particles/ranks.hpp"
#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/scenes.hpp"

#include <gtest/gtest.h>

#include <functional>

namespace poretwin::fluid {
namespace {

using namespace test;
using poretwin::test::ThreadRanks;

constexpr double dx = 0.01;

/// A basin between two walls.
void add_basin(double left, double right, Case& scene) {
  for (const auto& side : {line(left, 0.4, left, 0.0), line(left, 0.0, right, 0.0), line(right, 0.0, right, 0.4)})
    scene.walls.push_back(wall(side));
}

Case dry() {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = dx;
  scene.fluid.pressure_tolerance = 1e-14;
  return scene;
}

/// The first of these regions of water belongs to rank 0, the second to rank 1.
using Regions = std::array<Shape, 2>;

/// The scene as a rank sees it: with its own water.
Case part_of(const Case& scene, std::size_t rank, const std::vector<Shape>& regions) {
  Case own = scene;
  own.fluid.regions = regions;
  own.fluid.seed += static_cast<unsigned>(rank);
  return own;
}

/// What a soil that moves sends in every window; empty: nothing.
using Sent = std::function<coupling::Inbox(const Particles<2>&)>;

struct Twenty {
  double most = 1e-6;             ///< relative bound
  double interval = 0.0;          ///< s, of the windows; 0: those that the fluid proposes, which are the same on all
  double most_of_windows = 1e-6;  ///< relative bound on the windows and on the proposal after the last
  Sent sent = {};
};

/// Runs the scene with both regions on one rank, and with each on its own, for twenty windows. Compares each particle.
/// The bound is far above what the solves leave over and rounding adds (1e-8), and far below what a decision of one
/// rank alone changes.
void expect_the_same(Case scene, const Regions& regions, const Twenty& windows = {}) {
  const double most = windows.most;
  const auto run = [&](Fluid<2>& phase, double& time) {
    const auto inbox = [&] { return windows.sent ? windows.sent(phase.state().particles) : coupling::Inbox(); };
    phase.initialise(inbox());
    ScalarArray intervals;
    for (std::uint64_t step = 0; step < 20; ++step) {
      intervals.push_back(windows.interval > 0.0 ? windows.interval : phase.proposal().first);
      phase.advance({step, time, intervals.back()}, inbox());
      time += intervals.back();
    }
    intervals.push_back(phase.proposal().first);
    return intervals;
  };
  scene.fluid.regions = {regions[0], regions[1]};
  Fluid<2> one(scene);
  double end = 0.0;
  const ScalarArray intervals = run(one, end);
  const auto& whole = one.state().particles;
  std::array<Particles<2>, 2> parts;
  std::array<std::vector<TimeLimit>, 2> limits;
  ThreadRanks two(2);
  two.run([&](std::size_t rank, const Ranks& ranks) {
    Fluid<2> fluid(part_of(scene, rank, {regions[rank]}), Domain(ranks, 0, 0));
    double time = 0.0;
    const ScalarArray here = run(fluid, time);
    for (std::size_t i = 0; i < here.size(); ++i)
      EXPECT_NEAR(here[i], intervals[i], windows.most_of_windows * intervals[i]) << i;
    const State<2>&state = fluid.state(), &expected = one.state();
    EXPECT_NEAR(state.pressure_change, expected.pressure_change, windows.most_of_windows * expected.pressure_change);
    EXPECT_NEAR(state.widest_range, expected.widest_range, windows.most_of_windows * expected.widest_range);
    EXPECT_NEAR(state.controlled, expected.controlled, windows.most_of_windows * expected.controlled);
    parts[rank] = state.particles;
    limits[rank] = state.window_limits;
  });
  EXPECT_GT(two.meetings(), 100U);
  // Of each kind of limit, the least of the ranks.
  for (const TimeLimit& limit : one.state().window_limits) {
    double least = HUGE_VAL;
    for (const auto& own : limits)
      for (const TimeLimit& other : own)
        if (other.reason == limit.reason) least = std::min(least, other.interval);
    EXPECT_TRUE(least == limit.interval || std::abs(least - limit.interval) <= windows.most_of_windows * limit.interval)
        << limit.reason << ": " << least << ", " << limit.interval;
  }
  ASSERT_EQ(parts[0].size() + parts[1].size(), whole.size());
  ASSERT_TRUE(parts[0].size() > 0 && parts[1].size() > 0);
  double fastest = 0.0, moved = 0.0, differs = 0.0;
  for (const auto& part : parts)
    for (std::size_t i = 0; i < part.size(); ++i) {
      std::size_t a = 0;  // the nearest: births change the order
      for (std::size_t b = 1; b < whole.size(); ++b)
        if ((whole.position[b] - part.position[i]).norm() < (whole.position[a] - part.position[i]).norm()) a = b;
      fastest = std::max(fastest, whole.velocity[a].norm());
      moved = std::max(moved, (whole.position[a] - part.position[i]).norm());
      differs = std::max(differs, (whole.velocity[a] - part.velocity[i]).norm());
    }
  EXPECT_GT(fastest, 0.0);
  EXPECT_LT(moved, most * dx);
  EXPECT_LT(differs, most * fastest);
}

TEST(FluidOnRanks, TwoDamsBreakAsOnOne) {
  Case scene = dry();
  add_basin(0.0, 0.4, scene);
  add_basin(1.0, 1.3, scene);
  expect_the_same(scene, {box(0.0, 0.0, 0.1, 0.15), box(1.0, 0.0, 1.05, 0.3)});
}

/// Water in two columns of soil that gives way under a load: pressure and skeleton are solved together. The bound is
/// that of the solve of both, whose tolerance is 1e-4; iterations that differ from rank to rank end the run.
TEST(FluidOnRanks, ASkeletonRespondsAsOnOne) {
  Case scene;
  scene.general.gravity.setZero();
  scene.fluid.particle_spacing = dx;
  for (const double left : {0.0, 1.0}) {
    const double right = left + 0.04, top = left > 0.0 ? 0.12 : 0.2;
    scene.soils.push_back(sand());
    scene.soils.back().shape = box(left, 0.0, right, top);
    for (const auto& side : {line(left, 0.3, left, 0.0), line(left, 0.0, right, 0.0), line(right, 0.0, right, 0.3)})
      scene.walls.push_back(wall(side));
    scene.water_faces.push_back(pressure_face(line(right, top, left, top), 0.0));
  }
  const Sent sent = [](const Particles<2>& p) {
    const std::size_t n = p.size();
    coupling::Inbox box;
    box.coverage.assign(n, 1.0);
    box.asymmetry.assign(n, 0.0);
    const auto add = [&](std::string_view name, int components, const auto& value) {
      coupling::Field field{std::string(name), components, {}};
      for (std::size_t a = 0; a < n; ++a) {
        if (components == 2) field.values.push_back(0.0);
        field.values.push_back(value(p.position[a]));
      }
      box.fields.push_back(std::move(field));
    };
    const auto constant_of = [](double value) { return [value](const Vec<2>&) { return value; }; };
    add(coupling::field::solid_velocity, 2, constant_of(0.0));
    add(coupling::field::mean_solid_velocity, 2, constant_of(0.0));
    add(coupling::field::volumetric_strain_rate, 1, constant_of(0.0));
    add(coupling::field::unbalanced_force, 2, [](const Vec<2>& x) { return x.x() > 0.5 ? -2e3 : -5e3; });
    add(coupling::field::solid_volume_fraction, 1, constant_of(0.6));
    add(coupling::field::grain_density, 1, constant_of(2600.0));
    add(coupling::field::constrained_modulus, 1, [](const Vec<2>& x) { return x.x() > 0.5 ? 4e6 : 1e6; });
    add(coupling::field::yielding, 1, constant_of(0.0));
    add(coupling::field::hydraulic_conductivity, 1, constant_of(1e-4));
    add(coupling::field::forchheimer_coefficient, 1, constant_of(0.0));
    add(coupling::field::returned_impulse, 2, constant_of(0.0));
    return box;
  };
  expect_the_same(scene, {box(0.0, 0.0, 0.04, 0.2), box(1.0, 0.0, 1.04, 0.12)},
                  {.most = 1e-2, .interval = 2e-4, .most_of_windows = 0.1, .sent = sent});
}

/// Explicit sweeps have limits of their own.
TEST(FluidOnRanks, ExplicitSweepsTakeTheSameWindows) {
  Case scene = dry();
  scene.fluid.pressure_tolerance.reset();
  scene.fluid.scheme = FluidCase::Scheme::eisph;
  add_basin(0.0, 0.4, scene);
  add_basin(1.0, 1.3, scene);
  expect_the_same(scene, {box(0.0, 0.0, 0.1, 0.15), box(1.0, 0.0, 1.05, 0.3)});
}

}  // namespace
}  // namespace poretwin::fluid
