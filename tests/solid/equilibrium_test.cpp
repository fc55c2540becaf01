// The equilibrium of soil that cannot yield, by conjugate gradients: held against dynamic relaxation.
#include "solid_solver/phase.hpp"
#include "tests/solid/scenes.hpp"

#include <gtest/gtest.h>

#include <cstdio>

namespace poretwin::solid {
namespace {

using test::column;
using test::ColumnSpec;

/// Gravity put on soil without stress, by dynamic relaxation and by conjugate gradients.
template <int D>
void expect_the_same_equilibrium(const ColumnSpec& spec) {
  Case scene = column(spec);
  scene.solid.initial_rest = false;
  scene.soils[0].youngs_modulus *= 100.0;  // strains of 4e-5: steps of other size then sum up to the same strain
  const Solid<D> solid(scene);
  const Setup<D>& setup = solid.setup();
  const std::size_t n = solid.state().particles.free();
  const auto weight_alone = [n](Drive<D>& drive, bool) { drive.distributed.assign(n, Vec<D>::Zero()); };
  State<D> relaxed = solid.state(), solved = solid.state();
  const auto slow = find_rest<D>(setup, {1e-6, 500.0, 500.0}, relaxed, weight_alone, [](const RestReport&) {});
  ASSERT_TRUE(slow.reached());

  const Stiffness<D> stiffness(setup, solved.particles, solved.particles.position, ScalarArray(n, 0.0));
  Drive<D> drive;
  weight_alone(drive, true);
  EXPECT_NEAR(departure(setup, stiffness, solved, drive), 1.0, 1e-9);  // all of the weight is missing
  const auto fast = find_elastic_rest<D>(setup, stiffness, 1e-4, 200, solved, weight_alone);
  ASSERT_TRUE(fast.reached());
  EXPECT_LT(departure(setup, stiffness, solved, drive), 2e-4);

  double wrong = 0.0, moved = 0.0, stress_wrong = 0.0, stress = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const auto &a = solved.particles, &b = relaxed.particles;
    wrong += (a.displacement[i] - b.displacement[i]).squaredNorm();
    moved += b.displacement[i].squaredNorm();
    stress_wrong += (a.stress[i] - b.stress[i]).squaredNorm();
    stress += b.stress[i].squaredNorm();
  }
  std::printf("%dD: %zu displacements instead of %zu steps; displacement %.2g, stress %.2g off (rms)\n", D, fast.steps,
              slow.steps, std::sqrt(wrong / moved), std::sqrt(stress_wrong / stress));
  EXPECT_LT(std::sqrt(wrong / moved), 1e-3);
  EXPECT_LT(std::sqrt(stress_wrong / stress), 1e-3);
  EXPECT_LT(fast.steps, slow.steps / 5);
}

TEST(Equilibrium, OfABlockOnAFixedBase) {
  ColumnSpec spec;
  spec.sides = false;
  expect_the_same_equilibrium<2>(spec);
}

TEST(Equilibrium, OfAColumnBetweenRollers) { expect_the_same_equilibrium<2>({}); }

TEST(Equilibrium, InThreeDimensions) {
  ColumnSpec spec;
  spec.dimension = 3;
  spec.sides = false;
  spec.height = 0.5;
  expect_the_same_equilibrium<3>(spec);
}

}  // namespace
}  // namespace poretwin::solid
