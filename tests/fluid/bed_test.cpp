// Walls that let water through: particles give it to the ground and take it from there.
#include "fluid_solver/discretisation/operators.hpp"
#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/scenes.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace poretwin::fluid {
namespace {

using namespace test;

constexpr double dx = 0.02, length = 0.2, depth = 0.2;

Case tank(double level = depth) {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = dx;
  scene.fluid.regions = {box(0.0, 0.0, length, level)};
  scene.walls = {wall(line(0.0, 1.0, 0.0, 0.0)), wall(line(0.0, 0.0, length, 0.0)),
                 wall(line(length, 0.0, length, 1.0))};
  return scene;
}

/// The tank's floor as a bed, in parts of a spacing.
std::vector<BedPart<2>> bed_on_floor() {
  std::vector<BedPart<2>> bed(10);
  for (std::size_t i = 0; i < bed.size(); ++i) {
    bed[i].centre = Vec<2>((static_cast<double>(i) + 0.5) * dx, 0.0);
    bed[i].normal = Vec<2>(0.0, 1.0);
  }
  return bed;
}

double film_of(const Fluid<2>& fluid) {
  double sum = 0.0;
  for (const auto& part : fluid.state().bed) sum += part.film;
  return sum;
}

/// Lets the ground take q [m/s] through the floor until a time, in steps of `cycle`.
void drain(Fluid<2>& fluid, double& time, double end, double q, double cycle) {
  while (time < end - 1e-9) {
    std::vector<double> film;
    for (const auto& part : fluid.state().bed) film.push_back(part.film - q * dx * cycle);
    fluid.turn_over(film, cycle);
    run_to(fluid, time, time + cycle);
  }
}

double top_of(const Fluid<2>& fluid) {
  double top = 0.0;
  for (const auto& x : fluid.state().particles.position) top = std::max(top, x.y());
  return top;
}

/// Largest error of the particles' pressure heads [m] in water at rest: the piezometric pressure follows the level.
double head_error(const Fluid<2>& fluid, double first_level, double first_pressure) {
  const double risen = fluid.volume() / length - first_level;
  double worst = 0.0;
  for (const double p : fluid.state().particles.pressure)
    worst = std::max(worst, std::abs((p - first_pressure) / (1000.0 * 9.81) - risen));
  return worst;
}

double mean_head_before_bed(const Fluid<2>& fluid) {
  double sum = 0.0;
  const auto before = fluid.water_before_bed();
  for (const auto& water : before) sum += water.head;
  return sum / static_cast<double>(before.size());
}

// Rows before the bed that grow lift all rows above them. The divergence that the sums over pairs show of this motion
// is the smoothed growth, not the growth itself.
TEST(Bed, TheSourceIsTheDivergenceThatPairsShow) {
  const Walls<2> walls(tank(), {});
  const std::size_t columns = 10, rows = 14;
  VecArray<2> x, v;
  BedPassage passage;
  ScalarArray growth;
  for (std::size_t j = 0; j < rows; ++j)
    for (std::size_t i = 0; i < columns; ++i) {
      const auto growth_of = [](std::size_t row) {
        const double y = static_cast<double>(row) + 0.5;
        return y < 4.0 ? std::pow(std::cos(M_PI * y / 8.0), 2) : 0.0;
      };
      double lift = 0.5 * dx * growth_of(j);  // exact: of a row's centre
      for (std::size_t below = 0; below < j; ++below) lift += dx * growth_of(below);
      x.emplace_back((static_cast<double>(i) + 0.5) * dx, (static_cast<double>(j) + 0.5) * dx);
      v.emplace_back(0.0, lift);
      growth.push_back(growth_of(j));
      passage.gained.push_back(dx * dx * growth.back());
    }
  const auto s = make_stencil<2>(x, ScalarArray(x.size(), dx * dx), {}, walls.planes);
  ScalarArray source(x.size(), 0.0);
  add_bed_source<2>(passage, 1.0, s, source);
  const auto shown = divergence<2>(s, v);
  double error = 0.0, of_growth = 0.0;
  for (std::size_t a = 0; a < columns * (rows - 4); ++a) {  // the uppermost rows lack neighbours
    error = std::max(error, std::abs(source[a] - shown[a]));
    of_growth = std::max(of_growth, std::abs(growth[a] - shown[a]));
  }
  EXPECT_LT(error, 0.03);
  EXPECT_GT(of_growth, 0.08);
}

// Exact: the level falls by q t, the pressure at the bed is that of the depth.
TEST(Bed, WhatTheGroundTakesLeavesTheParticles) {
  Fluid<2> fluid(tank());
  fluid.lay_bed(bed_on_floor());
  fluid.initialise({});
  const double q = 0.005, first = fluid.volume();
  double time = 0.0;
  for (const double end : {4.0, 12.0, 20.0}) {
    drain(fluid, time, end, q, 0.05);
    const double level = depth - q * end;
    EXPECT_NEAR(fluid.volume() + film_of(fluid), first - q * length * end, 1e-13);
    EXPECT_LT(std::abs(film_of(fluid)), 1.01 * q * length * 0.05) << end;
    EXPECT_NEAR(top_of(fluid) + 0.5 * dx, level, 0.5 * dx) << end;
    EXPECT_NEAR(mean_head_before_bed(fluid), level, 0.1 * dx) << end;
    double fastest = 0.0;
    for (const auto& v : fluid.state().particles.velocity) fastest = std::max(fastest, v.norm());
    EXPECT_LT(fastest, 0.05 * std::sqrt(9.81 * depth)) << end;
  }
}

// Exact: the level rises by q t, the pressures are hydrostatic at any time. The first second is left out: the flow
// begins suddenly.
TEST(Bed, WhatTheGroundGivesComesIntoTheParticles) {
  struct Pond {
    double level, jitter, level_tolerance, head_tolerance;
  };
  // Five rows, two rows, and five rows in disorder.
  for (const Pond& pond :
       {Pond{5 * dx, 0.0, 0.05, 0.05}, Pond{2 * dx, 0.0, 0.05, 0.05}, Pond{5 * dx, 0.1, 0.15, 0.4}}) {
    Case scene = tank(pond.level);
    scene.fluid.jitter = pond.jitter;
    Fluid<2> fluid(scene);
    fluid.lay_bed(bed_on_floor());
    fluid.initialise({});
    const double q = -0.005, first = fluid.volume(), first_pressure = fluid.state().particles.pressure[0];
    const std::size_t particles = fluid.state().particles.size();
    double time = 0.0, worst = 0.0;
    for (int step = 1; step <= 320; ++step) {
      drain(fluid, time, 0.05 * step, q, 0.05);
      if (time > 1.0) worst = std::max(worst, head_error(fluid, pond.level, first_pressure));
      if (step % 80 == 0) {
        EXPECT_NEAR(mean_head_before_bed(fluid), fluid.volume() / length, pond.level_tolerance * dx) << time;
      }
    }
    EXPECT_LT(worst, pond.head_tolerance * dx);
    if (pond.jitter == 0.0) {
      EXPECT_NEAR(top_of(fluid) + 0.5 * dx, fluid.volume() / length, 0.15 * dx);
    }
    EXPECT_NEAR(fluid.volume() + film_of(fluid), first - q * length * 16.0, 1e-13);
    EXPECT_GT(fluid.state().particles.size(), particles + 20);  // 40 volumes came in: particles that grow divide
  }
}

// Volumes stay within the bounds at which particles merge and divide, and momentum and mass agree with them.
TEST(Bed, ParticlesThatShrinkMerge) {
  Fluid<2> fluid(tank());
  fluid.lay_bed(bed_on_floor());
  fluid.initialise({});
  double time = 0.0;
  drain(fluid, time, 10.0, 0.005, 0.05);
  const auto& p = fluid.state().particles;
  EXPECT_LT(p.size(), 90u);  // of 100, a quarter of the water has gone
  for (std::size_t a = 0; a < p.size(); ++a) {
    EXPECT_NEAR(p.mass[a], 1000.0 * p.volume[a], 1e-12);
    EXPECT_GT(p.volume[a], 0.4 * dx * dx);
    EXPECT_LT(p.volume[a], 1.7 * dx * dx);
  }
}

// The last water goes, too, and what is too little for a particle stays on the bed as a film.
TEST(Bed, APondCanBeEmptied) {
  Fluid<2> fluid(tank(0.06));
  fluid.lay_bed(bed_on_floor());
  fluid.initialise({});
  const double first = fluid.volume(), q = 0.01;
  double time = 0.0, taken = 0.0;
  while (time < 8.0) {
    const auto water = fluid.water_before_bed();
    std::vector<double> film;
    for (std::size_t i = 0; i < water.size(); ++i) {
      const double there = std::max(0.0, fluid.state().bed[i].film + water[i].volume);
      const double takes = std::min(q * dx * 0.05, there);
      taken += takes;
      film.push_back(fluid.state().bed[i].film - takes);
    }
    fluid.turn_over(film, 0.05);
    run_to(fluid, time, time + 0.05);
  }
  EXPECT_NEAR(fluid.volume() + film_of(fluid) + taken, first, 1e-13);
  EXPECT_GT(taken, 0.99 * first);
}

TEST(Bed, DryGroundMakesParticlesOfWhatComesOut) {
  Case scene = tank(0.06);
  scene.fluid.regions = {box(0.0, 0.0, 0.04, 0.04)};  // the rest of the floor is dry
  scene.walls.push_back(wall(line(0.06, 0.0, 0.06, 0.1)));
  scene.walls.push_back(wall(line(0.08, 0.1, 0.08, 0.0)));
  Fluid<2> fluid(scene);
  auto bed = bed_on_floor();
  fluid.lay_bed(bed);
  fluid.initialise({});
  const double first = fluid.volume();
  std::vector<double> film(10, 0.0);
  film[8] = 0.6 * dx * dx;
  fluid.turn_over(film, 0.1);
  double time = 0.0;
  run_to(fluid, time, 0.2);
  EXPECT_NEAR(fluid.volume(), first, 1e-15);  // too little for a particle
  film[8] += 0.6 * dx * dx;
  fluid.turn_over(film, 0.1);
  run_to(fluid, time, 0.25);
  EXPECT_NEAR(fluid.volume() + film_of(fluid), first + 1.2 * dx * dx, 1e-15);
  EXPECT_GT(fluid.volume(), first + 0.99 * dx * dx);
}

}  // namespace
}  // namespace poretwin::fluid
