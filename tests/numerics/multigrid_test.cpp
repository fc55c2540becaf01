// The multigrid preconditioner: the same solution, in a number of cycles that does not grow with the size.
#include "common/numerics/multigrid.hpp"

#include <gtest/gtest.h>

#include <random>

namespace poretwin {
namespace {

struct Grid {
  std::vector<Index> offset{0}, neighbour;
  PairMatrix matrix;
};

/// Five-point Laplacian on a square of side^2 rows, with random weights, stronger along one axis in one half; one side
/// is fixed, or none.
Grid grid(std::size_t side, bool closed) {
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> scatter(0.5, 1.5);
  const auto at = [&](std::size_t i, std::size_t j) { return j * side + i; };
  std::vector<std::vector<std::pair<Index, double>>> rows(side * side);
  const auto join = [&](std::size_t a, std::size_t b, double w) {
    rows[a].emplace_back(static_cast<Index>(b), w);
    rows[b].emplace_back(static_cast<Index>(a), w);
  };
  for (std::size_t j = 0; j < side; ++j)
    for (std::size_t i = 0; i < side; ++i) {
      const double along = 2 * i < side ? 1.0 : 1e-3;
      if (i + 1 < side) join(at(i, j), at(i + 1, j), along * scatter(generator));
      if (j + 1 < side) join(at(i, j), at(i, j + 1), scatter(generator));
    }
  Grid g;
  PairMatrix& m = g.matrix;
  for (std::size_t a = 0; a < rows.size(); ++a) {
    double sum = 0.0;
    for (const auto& [b, w] : rows[a]) {
      g.neighbour.push_back(b);
      m.weight.push_back(static_cast<float>(w));
      sum += static_cast<double>(m.weight.back());
    }
    for (; g.neighbour.size() % n_lanes != 0; m.weight.push_back(0.0F)) g.neighbour.push_back(static_cast<Index>(a));
    g.offset.push_back(static_cast<Index>(g.neighbour.size()));
    m.diagonal.push_back(!closed && a < side ? 1e3 * sum : sum);
  }
  return g;
}

int solve(Grid g, bool closed, ScalarArray& x) {
  PairMatrix& m = g.matrix;
  m.column = {g.offset, g.neighbour, {}, {}};
  std::mt19937_64 generator(7);
  std::uniform_real_distribution<double> noise(-1.0, 1.0);
  ScalarArray b(m.size());
  double mean = 0.0;
  for (double& value : b) mean += (value = noise(generator)) / static_cast<double>(b.size());
  for (double& value : b) value -= closed ? mean : 0.0;
  x.assign(m.size(), 0.0);
  Multigrid multigrid(m);
  const auto report = conjugate_gradients(
      Domain(), [&](std::span<const double> u, std::span<double> y) { m.apply(u, y); },
      [&](std::span<const double> r, std::span<double> z) { multigrid.cycle(r, z); }, b, x, 1e-8 * Domain().norm(b), 100);
  EXPECT_TRUE(report.converged);
  ScalarArray row(m.size());
  m.apply(std::span<const double>(x), std::span<double>(row));
  for (std::size_t a = 0; a < row.size(); ++a) row[a] -= b[a];
  EXPECT_LE(Domain().norm(row), 2e-8 * Domain().norm(b));
  return report.iterations;
}

TEST(Multigrid, CyclesDoNotGrowWithSize) {
  for (const bool closed : {false, true}) {
    ScalarArray x;
    const int few = solve(grid(20, closed), closed, x), many = solve(grid(200, closed), closed, x);
    EXPECT_LE(few, 25);
    EXPECT_LE(many, 1.6 * few) << "a hundred times as many rows";
  }
}

TEST(Multigrid, HalfOfACoarseMatrixIsAllOfIt) {
  Grid g = grid(15, true);
  g.matrix.column = {g.offset, g.neighbour, {}, {}};
  const std::size_t n = g.matrix.size();
  WholeMatrix whole{g.offset, g.neighbour, {}, {}};
  for (const float w : g.matrix.weight) whole.weight.push_back(static_cast<double>(w) / 3.0);
  for (std::size_t a = 0; a < n; ++a) whole.diagonal.push_back(g.matrix.diagonal[a] / 3.0);
  const CoarseMatrix half(whole);
  std::mt19937_64 generator(5);
  std::uniform_real_distribution<double> noise(-1.0, 1.0);
  ScalarArray x(n), product(n), pairs(n, 0.0), constants(n, 0.0);
  for (double& value : x) value = noise(generator);
  g.matrix.apply(x, product);
  const ScalarArray one(n, 1.0);
  for (std::size_t a = 0; a < n; ++a) {
    pairs[a] += half.off_diagonal_sum(a, x.data());
    half.push(a, x[a], pairs.data());
    constants[a] += half.off_diagonal_sum(a, one.data());
    half.push(a, 1.0, constants.data());
  }
  for (std::size_t a = 0; a < n; ++a) {
    EXPECT_NEAR(half.diagonal(a) * x[a] - pairs[a], product[a] / 3.0, 1e-6 * whole.diagonal[a]) << "rounded to floats";
    EXPECT_NEAR(half.diagonal(a), constants[a], 1e-14 * whole.diagonal[a])
        << "constants are in the kernel all the same";
  }
}

TEST(Multigrid, RowsWithoutNeighboursAreNoProblem) {
  Grid g = grid(12, false);
  for (int i = 0; i < 30; ++i) {
    g.offset.push_back(g.offset.back());
    g.matrix.diagonal.push_back(2.0);
  }
  ScalarArray x;
  EXPECT_LE(solve(std::move(g), false, x), 20);
}

}  // namespace
}  // namespace poretwin
