// Regions at rest around flowing soil.
#include "solid_solver/sleep/regions.hpp"
#include "tests/solid/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace poretwin::solid::test {
namespace {

const ColumnSpec low{.width = 2.0, .height = 0.5, .base = Wall::ForSoil::none, .sides = false};

Face line(std::vector<Point3> points) {
  Face face;
  face.points = std::move(points);
  return face;
}

/// A low, wide stack of grains after its gate is removed; its core does not move.
Case collapse(double regions) {
  Case scene = column(low);
  scene.soils[0].friction_angle = 31.0;
  scene.soils[0].cone = Soil::Cone::repose;
  scene.solid.model = SolidCase::Model::drucker_prager;
  scene.solid.initial_rest = false;
  scene.solid.quiet = Quiet{.sleep_below = 1e-9, .regions = regions};
  Wall base, back;
  base.face = line({{0.0, 0.0, 0.0}, {4.0, 0.0, 0.0}});
  base.soil = Wall::ForSoil::rough;
  back.face = line({{0.0, 1.0, 0.0}, {0.0, -0.2, 0.0}});
  back.soil = Wall::ForSoil::roller;
  scene.walls = {base, back};
  return scene;
}

std::size_t count_asleep(const Solid<2>& solid) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < solid.state().particles.free(); ++i) count += solid.state().regions.sleeps(i) ? 1 : 0;
  return count;
}

double tip(const Solid<2>& solid) {
  double far = 0.0;
  for (std::size_t i = 0; i < solid.state().particles.free(); ++i)
    far = std::max(far, solid.state().particles.position[i].x());
  return far;
}

/// Mean vertical stress [Pa] of soil below 0.2 m and within 0.6 m of the back wall.
double core_stress(const Solid<2>& solid) {
  const auto& p = solid.state().particles;
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < p.free(); ++i)
    if (p.position[i].x() < 0.6 && p.position[i].y() < 0.2) sum += p.stress[i][1], count += 1.0;
  return sum / count;
}

constexpr double at_rest = 1.2, window = 0.01;  // s
// At this time 58 to 289 of the core's 400 particles sleep, for substeps from 0.6 to 1.05 of the Courant number: waves
// in the row on the base are as strong as the limit for waking.
constexpr std::size_t many = 50;

TEST(Regions, OfACollapseSleepAndErrLittle) {
  Solid<2> whole(collapse(0.0)), solid(collapse(5e-3));
  for (auto* each : {&whole, &solid}) {
    each->initialise({});
    run_dry(*each, at_rest, window);
  }
  EXPECT_EQ(count_asleep(whole), 0u);
  EXPECT_GT(count_asleep(solid), many);
  EXPECT_GT(solid.counters().at("share asleep beside soil that flows"), 0.05);
  EXPECT_NEAR(tip(solid), tip(whole), 0.05);  // one spacing
  // In the run without sleep the undamped core oscillates by a tenth of its weight; sleeping soil has the stress of
  // level ground.
  const double density = 0.6 * 2600.0;
  EXPECT_NEAR(core_stress(solid), -density * 9.81 * (low.height - 0.1), 0.02 * density * 9.81 * low.height);
  // Sleeping soil does not change by a single bit.
  const auto before = solid.state().particles;
  const auto asleep = solid.state().regions.asleep;
  run_dry(solid, at_rest + window, window);
  for (std::size_t i = 0; i < before.free(); ++i) {
    if (!asleep[i] || !solid.state().regions.sleeps(i)) continue;
    EXPECT_EQ(solid.state().particles.position[i], before.position[i]);
    EXPECT_EQ(solid.state().particles.stress[i], before.stress[i]);
    EXPECT_EQ(solid.state().particles.volume[i], before.volume[i]);
  }
}

TEST(Regions, WakeForALoad) {
  Case scene = collapse(5e-3);
  Load load = top_load(low, 2000.0, at_rest);
  load.face = line({{0.6, 0.5, 0.0}, {0.0, 0.5, 0.0}});
  scene.loads = {load};
  Solid<2> solid(scene);
  solid.initialise({});
  run_dry(solid, at_rest, window);
  const double stress = core_stress(solid);
  const std::size_t asleep = count_asleep(solid);
  ASSERT_GT(asleep, many);
  run_dry(solid, at_rest + 0.03, window);
  EXPECT_LT(count_asleep(solid), asleep / 2);
  run_dry(solid, at_rest + 0.1, window);
  EXPECT_LT(core_stress(solid), stress - 1000.0) << "the load does not come through";
}

TEST(Regions, WakeForWater) {
  Case scene = collapse(5e-3);
  PorePressure water;
  water.head = Series{{{0.0, -1.0}, {at_rest, -1.0}, {at_rest + 0.05, 0.3}}};
  scene.pore_pressures = {water};
  Solid<2> solid(scene);
  solid.initialise({});
  run_dry(solid, at_rest, window);
  const double stress = core_stress(solid);
  ASSERT_GT(count_asleep(solid), many);
  run_dry(solid, at_rest + 0.15, window);
  EXPECT_GT(core_stress(solid), stress + 1000.0) << "no buoyancy";
}

/// Forces on particles that are computed do not depend on which ones sleep, nor on the number of parts.
TEST(Regions, FeelAllTheirNeighbours) {
  for (const std::size_t parts : {1u, 3u}) {
    auto [setup, particles] = set_up<2>(collapse(5e-3));
    setup.parts = parts;
    State<2> state;
    state.particles = std::move(particles);
    const std::size_t n = state.particles.size(), free = state.particles.free();
    state.body.assign(n, Vec<2>::Zero());
    state.force.assign(n, {});
    for (std::size_t i = 0; i < n; ++i) {
      const Vec<2>& x = state.particles.position[i];
      state.particles.stress[i] << -1e3 * x.y() * x.x(), -3e3 * (0.5 - x.y()), -1e3, 300.0 * std::sin(5.0 * x.x()), 0.0,
          0.0;
    }
    rebuild(setup, state);
    evaluate_forces(setup, state);
    const auto all = state.force;
    const auto neighbours = [&] {
      std::vector<std::size_t> count(free, 0);
      for_each_ordered_pair(state.near.pairs, [&](std::size_t i, std::size_t, std::size_t) {
        if (i < free) ++count[i];
      });
      return count;
    };
    const auto found = neighbours();
    state.regions.asleep.assign(free, 0);
    for (std::size_t i = 0; i < free; ++i) state.regions.asleep[i] = state.particles.position[i].x() < 1.0 ? 1 : 0;
    rebuild_lists(setup, state);
    for (auto& f : state.force) f.sum.x.fill(1e30);
    evaluate_forces(setup, state);
    std::size_t skipped = 0;
    for (std::size_t i = 0; i < free; ++i) {
      if (state.near.pairs.skips(i)) {
        EXPECT_LT(state.particles.position[i].x(), 1.0);
        EXPECT_EQ(state.force[i].internal().x(), 1e30);
        ++skipped;
      } else {
        EXPECT_NEAR((state.force[i].internal() - all[i].internal()).norm(), 0.0,
                    1e-9 * (1.0 + all[i].internal().norm()));
      }
    }
    EXPECT_GT(skipped, free / 3);
    EXPECT_EQ(neighbours(), found) << "whoever asks for the neighbours of sleepers finds them";
  }
}

}  // namespace
}  // namespace poretwin::solid::test
