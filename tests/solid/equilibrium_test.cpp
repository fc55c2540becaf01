// The equilibrium at the end of a window, compared with dynamic relaxation, and where soil yields with many small
// windows.
#include "solid_solver/phase.hpp"
#include "solid_solver/statics/axis_inverse.hpp"
#include "solid_solver/statics/equilibrium.hpp"
#include "tests/solid/scenes.hpp"

#include <gtest/gtest.h>

#include <Eigen/SparseCore>

#include <algorithm>
#include <cstdio>
#include <random>
#include <utility>

namespace poretwin::solid {
namespace {

using test::column;
using test::ColumnSpec;

/// Applies gravity to stress-free soil by dynamic relaxation, and by the search for equilibrium at once.
template <int D>
void expect_the_same_equilibrium(const ColumnSpec& spec) {
  Case scene = column(spec);
  scene.solid.initial_rest = false;
  scene.soils[0].youngs_modulus *= 100.0;  // strains of 4e-5: other step sizes then sum to the same strain
  const Solid<D> solid(scene);
  const Setup<D>& setup = solid.setup();
  const std::size_t n = solid.state().particles.free();
  const auto weight_alone = [n](Drive<D>& drive, bool) { drive.distributed.allocate(n); };
  State<D> relaxed = solid.state(), solved = solid.state();
  const auto slow = find_rest<D>(setup, {1e-6, 500.0, 500.0}, relaxed, weight_alone, [](const RestReport&) {});
  ASSERT_TRUE(slow.reached());

  const Stiffness<D> stiffness(setup, solved.particles, solved.particles.position, ScalarArray(n, 0.0));
  Drive<D> drive;
  weight_alone(drive, true);
  EXPECT_NEAR(departure(setup, stiffness, solved, drive), 1.0, 1e-9);  // the whole weight is unbalanced
  const VecArray<D> weight = all_forces(setup, solved, drive), moved_by_it = stiffness.displacements(weight);
  double done = 0.0;
  for (std::size_t i = 0; i < n; ++i) done += weight[i].dot(moved_by_it[i]);
  EXPECT_NEAR(stiffness.work(weight), done, 1e-12 * done);
  const auto fast = find_equilibrium<D>(setup, stiffness, {1e-4}, 1.0, solved, weight_alone);
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

/// The Laplacian of a cube of particles over a base that is held, with all 26 neighbours of each.
Eigen::SparseMatrix<double> cube_of(int side, double along, int axis) {
  const auto row = [&](int x, int y, int z) { return x + side * (y + side * z); };
  std::vector<Eigen::Triplet<double>> entries;
  for (int a = 0; a < side * side * side; ++a) {
    const std::array<int, 3> at{a % side, a / side % side, a / side / side};
    for (int k = 0; k < 27; ++k) {
      const std::array<int, 3> way{k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
      const std::array<int, 3> to{at[0] + way[0], at[1] + way[1], at[2] + way[2]};
      if (k == 13 || to[0] < 0 || to[1] < 0 || to[0] >= side || to[1] >= side || to[2] >= side) continue;
      const double strength = way[static_cast<std::size_t>(axis)] != 0 ? along : 1.0;
      entries.emplace_back(a, a, strength);
      if (to[2] >= 0) entries.emplace_back(a, row(to[0], to[1], to[2]), -strength);
    }
  }
  Eigen::SparseMatrix<double> matrix(side * side * side, side * side * side);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// In 3D the stiffness is inverted by iterations, for smooth forces and for such as alternate.
TEST(Stiffness, IsSolvedInSpaceAsByFactors) {
  constexpr int side = 16;
  const auto exact = by_factors<3>(), iterated = by_multigrid<3>();
  std::array<Eigen::SparseMatrix<double>, 3> matrix;
  for (int axis = 0; axis < 3; ++axis) {
    matrix[static_cast<std::size_t>(axis)] = cube_of(side, 3.0, axis);
    exact->add(matrix[static_cast<std::size_t>(axis)]);
    iterated->add(matrix[static_cast<std::size_t>(axis)]);
  }
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  VecArray<3> weight(side * side * side, Vec<3>(0.1, 0.0, -1.0)), noise = weight;
  for (Vec<3>& f : noise) f = Vec<3>(normal(random), normal(random), normal(random));
  for (const VecArray<3>& force : {weight, noise}) {
    const VecArray<3> x = exact->displacements(force), y = iterated->displacements(force);
    double wrong = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::VectorXd e(side * side * side);
      for (Eigen::Index i = 0; i < e.size(); ++i)
        e[i] = y[static_cast<std::size_t>(i)][axis] - x[static_cast<std::size_t>(i)][axis];
      wrong += e.dot(matrix[static_cast<std::size_t>(axis)] * e);
    }
    const double work = exact->work(force);
    std::printf("error of the energy's norm %.2g\n", std::sqrt(wrong / work));
    EXPECT_LT(std::sqrt(wrong / work), 0.01);
    EXPECT_NEAR(iterated->work(force), work, 1e-3 * work);
  }
}

/// Plastic strain and displacement [m] of a block whose foot yields, when its weight is applied in so many equal parts.
std::pair<double, double> loaded_in_parts(std::size_t parts, double criterion) {
  ColumnSpec spec;
  spec.sides = false;
  Case scene = column(spec);
  scene.solid.initial_rest = false;
  scene.solid.model = SolidCase::Model::drucker_prager;
  scene.soils[0].friction_angle = 30.0;
  scene.soils[0].dilation_angle = 5.0;
  scene.soils[0].cohesion = 5000.0;  // Pa: it stands, but its foot yields
  const Solid<2> solid(scene);
  const Setup<2>& setup = solid.setup();
  State<2> state = solid.state();
  const std::size_t n = state.particles.free();
  const Stiffness<2> stiffness(setup, state.particles, state.particles.position, ScalarArray(n, 0.0));
  for (std::size_t k = 1; k <= parts; ++k) {
    const double missing = static_cast<double>(k) / static_cast<double>(parts) - 1.0;
    const auto weight = [&](Drive<2>& drive, bool) {
      drive.distributed.allocate(n);
      for (std::size_t i = 0; i < n; ++i) drive.distributed.set(i, missing * state.particles.mass[i] * setup.gravity);
    };
    const auto report = find_equilibrium<2>(setup, stiffness, {criterion}, 1.0, state, weight);
    EXPECT_TRUE(report.reached()) << "part " << k << ": " << report.residual << " after " << report.steps;
    std::printf("part %zu of %zu: %zu displacements\n", k, parts, report.steps);
  }
  double plastic = 0.0, moved = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    plastic += state.particles.plastic_strain[i] / static_cast<double>(n);
    moved = std::max(moved, state.particles.displacement[i].norm());
  }
  return {plastic, moved};
}

TEST(Equilibrium, OfSoilThatYieldsHoldsNoStrainOfTheSearch) {
  const auto [strain, moved] = loaded_in_parts(4, 1e-4);
  const auto [exact_strain, exact_moved] = loaded_in_parts(32, 1e-6);
  std::printf("plastic strain %.4g (%.4g in small parts), moved %.4g mm (%.4g)\n", strain, exact_strain, 1e3 * moved,
              1e3 * exact_moved);
  ASSERT_GT(exact_strain, 1e-5);
  EXPECT_NEAR(strain, exact_strain, 0.03 * exact_strain);
  EXPECT_NEAR(moved, exact_moved, 0.01 * exact_moved);
}

TEST(Equilibrium, ThatDoesNotExistLeavesTheSoilAsItWas) {
  Case scene = column({});
  scene.solid.model = SolidCase::Model::drucker_prager;
  scene.soils[0].friction_angle = 30.0;
  Solid<2> solid(scene);
  solid.initialise({});
  const auto& setup = solid.setup();
  State<2> state = solid.state();
  const std::size_t n = state.particles.free();
  const Stiffness<2> stiffness(setup, state.particles, state.particles.position, ScalarArray(n, 0.0));
  const auto lifted = [&](Drive<2>& drive, bool) {  // by twice its weight: sand cannot hang from its base
    drive.distributed.allocate(n);
    for (std::size_t i = 0; i < n; ++i) drive.distributed.set(i, -2.0 * state.particles.mass[i] * setup.gravity);
  };
  EXPECT_FALSE(find_equilibrium<2>(setup, stiffness, {1e-4}, 1.0, state, lifted).reached());
  for (std::size_t i = 0; i < n; ++i) {
    ASSERT_EQ(state.particles.position[i], solid.state().particles.position[i]);
    ASSERT_EQ(state.particles.stress[i], solid.state().particles.stress[i]);
  }
}

// With a jump there, a search would find no equilibrium: its trials would lie on either side in turn.
TEST(Equilibrium, ForcesDoNotJumpWhereDilationEnds) {
  Case scene = column({});
  scene.solid.model = SolidCase::Model::drucker_prager;
  Soil& soil = scene.soils[0];
  soil.friction_angle = 30.0;
  soil.dilation_angle = 10.0;
  soil.maximum_void_ratio = 0.67;  // initially 0.6667: reached where the volume is larger by 0.002
  const Solid<2> solid(scene);
  const std::size_t n = solid.state().particles.free();
  const auto mean_stress_after = [&](double share) {
    State<2> state = solid.state();
    for (std::size_t i = 0; i < n; ++i) {
      state.particles.stress[i] << -1e4, -1e4, -1e4, 0.0, 0.0, 0.0;
      const double height = state.particles.position[i][1];
      state.particles.velocity[i] = share * Vec<2>(0.02 * height, 0.002 * height);
    }
    deform<2>(solid.setup(), 1.0, nullptr, state);
    const std::size_t middle = n / 2;
    EXPECT_TRUE(state.yielded[middle]);
    return trace(state.particles.stress[middle]) / 3.0;
  };
  const double before = mean_stress_after(1.0 - 1e-6), after = mean_stress_after(1.0 + 1e-6);
  EXPECT_NEAR(after, before, 1e-4 * std::abs(before));
}

}  // namespace
}  // namespace poretwin::solid
