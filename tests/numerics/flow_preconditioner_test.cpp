// Incomplete factors and multigrid together as the preconditioner of unsymmetric matrices of flows.
#include "common/numerics/flow_preconditioner.hpp"

#include "common/numerics/csr.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace poretwin {
namespace {

struct Flows {
  SparseRows matrix;
  ScalarArray scale, right;
};

/// Flows on a square of side^2 points with random conductances of about 1 between heads, a prescribed head along one
/// side, and a right-hand side that varies smoothly. `gravity`: in the upper half water falls; there its flow to the
/// point below is `gravity` times the upper point's head. `spread`: the unknowns are heads times factors between
/// 1 / spread and spread.
Flows flows(std::size_t side, double gravity, double spread) {
  std::mt19937_64 generator(5);
  std::uniform_real_distribution<double> conductance(0.5, 1.5), exponent(-1.0, 1.0);
  struct Pair {
    Index a, b;
    double by_a, by_b;  // of the flow from a to b, which is by_a h_a - by_b h_b
  };
  std::vector<Pair> pairs;
  std::vector<std::pair<Index, Index>> places;
  const auto at = [&](std::size_t i, std::size_t j) { return static_cast<Index>(i * side + j); };
  for (std::size_t i = 0; i < side; ++i)
    for (std::size_t j = 0; j < side; ++j) {  // j counts from the top down
      if (i + 1 < side) {
        const double k = conductance(generator);
        pairs.push_back({at(i, j), at(i + 1, j), k, k});
      }
      if (j + 1 < side) {
        const double k = conductance(generator);
        pairs.push_back({at(i, j), at(i, j + 1), k + (2 * j < side ? gravity : 0.0), k});
      }
    }
  for (const auto& p : pairs) {
    places.emplace_back(p.a, p.b);
    places.emplace_back(p.b, p.a);
  }
  const std::size_t n = side * side;
  Flows f{SparseRows(n, places), ScalarArray(n), ScalarArray(n)};
  for (double& s : f.scale) s = std::pow(spread, exponent(generator));
  const auto add = [&](Index row, Index column, double by_head) {
    f.matrix[f.matrix.place(row, column)] += by_head / f.scale[column];
  };
  for (const auto& p : pairs) {
    add(p.a, p.a, p.by_a);
    add(p.a, p.b, -p.by_b);
    add(p.b, p.a, -p.by_a);
    add(p.b, p.b, p.by_b);
  }
  for (std::size_t j = 0; j < side; ++j) add(at(0, j), at(0, j), 2.0);
  for (std::size_t i = 0; i < side; ++i)
    for (std::size_t j = 0; j < side; ++j)
      f.right[at(i, j)] = std::cos(M_PI * static_cast<double>(i + 2 * j) / static_cast<double>(side));
  return f;
}

constexpr int always = 1000, some = 8;

/// Iterations to a residual of 1e-6; `alone` of them at most by incomplete factors alone.
int iterations(const Flows& f, int alone) {
  FlowPreconditioner preconditioner(f.matrix, f.scale, alone);
  ScalarArray x(f.right.size()), product(x.size());
  const double length = Domain().norm(f.right);
  const auto report = flexible_gmres(
      Domain(), [&](auto u, auto y) { f.matrix.apply(u, y); }, [&](auto r, auto z) { preconditioner.apply(r, z); },
      f.right, x, 1e-6 * length, 200);
  f.matrix.apply(x, product);
  for (std::size_t a = 0; a < x.size(); ++a) product[a] -= f.right[a];
  if (report.converged) {
    EXPECT_LE(Domain().norm(product), 1.1e-6 * length);
  }
  return report.iterations;
}

TEST(FlowPreconditioner, TheNumberOfIterationsHardlyGrowsWithThatOfPoints) {
  const int coarse = iterations(flows(64, 0.0, 1.0), some), fine = iterations(flows(96, 0.0, 1.0), some);
  EXPECT_LE(fine, coarse + 4);
  EXPECT_GT(iterations(flows(96, 0.0, 1.0), always), 2 * fine);
}

TEST(FlowPreconditioner, GravityAndUnknownsOtherThanHeadsCostFewIterations) {
  const int heads = iterations(flows(64, 0.0, 1.0), some);
  EXPECT_LE(iterations(flows(64, 0.0, 100.0), some), heads + 4);
  EXPECT_LE(iterations(flows(64, 3.0, 100.0), some), 2 * heads);
}

TEST(FlowPreconditioner, MultigridDoesNotTakePartWhereIncompleteFactorsSuffice) {
  SparseRows column(100, [] {
    std::vector<std::pair<Index, Index>> places;
    for (Index a = 0; a + 1 < 100; ++a) {
      places.emplace_back(a, a + 1);
      places.emplace_back(a + 1, a);
    }
    return places;
  }());
  for (Index a = 0; a < 100; ++a)
    for (Index k = column.begin(a); k < column.end(a); ++k)
      column[k] = column.column(k) == a ? 5.0 : column.column(k) < a ? -3.0 : -1.0;
  Flows f{column, ScalarArray(100, 1.0), ScalarArray(100, 1.0)};
  EXPECT_EQ(iterations(f, some), 1);
}

}  // namespace
}  // namespace poretwin
