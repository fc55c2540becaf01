// The coarse space of pressures and of the skeleton's velocities solves for what is constant on its aggregates, and
// saves iterations.
#include "common/numerics/aggregates.hpp"
#include "common/numerics/csr.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace poretwin {
namespace {

/// A Laplacian of a square lattice with a small addition to its diagonal, for two components; one corner particle is no
/// member.
struct Lattice {
  std::size_t side;
  std::vector<Vec<2>> position;
  explicit Lattice(std::size_t n) : side(n) {
    for (std::size_t k = 0; k < n * n; ++k)
      position.emplace_back(static_cast<double>(k % n), static_cast<double>(k / n));
  }
  [[nodiscard]] bool member(std::size_t a) const { return a != 0; }
  /// Calls add(b, value) for every entry of the row of particle a.
  template <class Add>
  void row(std::size_t a, const Add& add) const {
    double sum = 1e-3;
    const auto join = [&](bool there, std::size_t b) {
      if (!there || !member(b)) return;
      add(b, -1.0);
      sum += 1.0;
    };
    join(a % side > 0, a - 1);
    join(a % side + 1 < side, a + 1);
    join(a >= side, a - side);
    join(a + side < position.size(), a + side);
    add(a, sum);
  }
  void apply(std::span<const double> x, std::span<double> y) const {
    std::fill(y.begin(), y.end(), 0.0);
    for (std::size_t a = 1; a < position.size(); ++a)
      row(a, [&](std::size_t b, double value) {
        for (std::size_t d = 0; d < 2; ++d) y[2 * a + d] += value * x[2 * b + d];
      });
  }
  [[nodiscard]] Aggregates<2> aggregates(double edge) const {
    Aggregates<2> made(position, edge, [&](std::size_t a) { return member(a); });
    made.factorise([&](std::size_t a, const auto& add) { row(a, add); });
    return made;
  }
};

TEST(Aggregates, SolveWhatIsConstantOnThem) {
  const Lattice lattice(12);
  const auto aggregates = lattice.aggregates(4.0);
  EXPECT_EQ(aggregates.size(), 9U);
  EXPECT_EQ(aggregates.of(0), Aggregates<2>::none);
  ScalarArray x(2 * 144, 0.0), r(2 * 144), z(2 * 144, 0.0);
  for (std::size_t a = 1; a < 144; ++a)
    for (std::size_t d = 0; d < 2; ++d) x[2 * a + d] = std::sin(1.0 + 3.0 * aggregates.of(a) + static_cast<double>(d));
  lattice.apply(x, r);
  aggregates.correct(r, z);
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(z[i], x[i], 1e-10) << i;
}

/// So many rows that they are divided among threads.
TEST(Aggregates, CorrectEveryFieldByItself) {
  const Lattice lattice(200);
  const auto aggregates = lattice.aggregates(20.0);
  const std::size_t n = lattice.position.size();
  ScalarArray both(2 * n), one(n), z(2 * n, 0.0), single(n, 0.0);
  for (std::size_t a = 0; a < n; ++a) {
    both[2 * a] = std::cos(static_cast<double>(a));
    both[2 * a + 1] = one[a] = std::sin(static_cast<double>(a));
  }
  aggregates.correct(both, z);
  aggregates.correct<1>(one, single);
  for (std::size_t a = 0; a < n; ++a) {
    EXPECT_EQ(z[2 * a + 1], single[a]);
    if (a > 1 && aggregates.of(a) == aggregates.of(a - 1)) {
      EXPECT_EQ(single[a], single[a - 1]);
    }
  }
}

TEST(Aggregates, SaveIterations) {
  const Lattice lattice(24);
  const auto aggregates = lattice.aggregates(4.0);
  const std::size_t n = 2 * lattice.position.size();
  ScalarArray b(n, 0.0);
  b[n / 2 + 7] = 1.0;
  const auto iterations = [&](bool corrected) {
    ScalarArray x(n, 0.0);
    const auto report =
        conjugate_gradients(Domain(), [&](std::span<const double> u, std::span<double> y) { lattice.apply(u, y); },
                            [&](std::span<const double> r, std::span<double> z) {
                              for (std::size_t i = 0; i < n; ++i) z[i] = r[i] / 4.0;
                              if (corrected) aggregates.correct(r, z);
                            },
                            b, x, 1e-6 * Domain().norm(b), 1000);
    EXPECT_TRUE(report.converged);
    return report.iterations;
  };
  EXPECT_LT(3 * iterations(true), 2 * iterations(false));
}

/// A search that ends by its `energy` is that close: thanks to the aggregates, residual . z estimates the error's
/// energy within a factor.
TEST(Aggregates, TellTheEnergyOfTheError) {
  const Lattice lattice(24);
  const auto aggregates = lattice.aggregates(4.0);
  const std::size_t n = 2 * lattice.position.size();
  ScalarArray b(n, 0.0);
  b[n / 2 + 7] = 1.0;
  const auto apply = [&](std::span<const double> u, std::span<double> y) { lattice.apply(u, y); };
  const auto solve = [&](double tolerance, double energy, ScalarArray& x) {
    return reduce_residual(
        Domain(), apply,
        [&](std::span<const double> r, std::span<double> z) {
          for (std::size_t i = 0; i < n; ++i) z[i] = r[i] / 4.0;
          aggregates.correct(r, z);
        },
        b, x, tolerance, 1000, energy);
  };
  ScalarArray exact(n, 0.0), work(n);
  const auto whole = solve(1e-12, 0.0, exact);
  ASSERT_TRUE(whole.converged);
  for (const double share : {1e-2, 1e-4, 1e-6}) {
    const double asked = share * Domain().dot(exact, b);
    ScalarArray x(n, 0.0);
    const auto report = solve(0.0, asked, x);
    EXPECT_TRUE(report.converged);
    EXPECT_LT(2 * report.iterations, whole.iterations + 10);
    for (std::size_t i = 0; i < n; ++i) x[i] -= exact[i];
    apply(x, work);
    EXPECT_LT(Domain().dot(x, work), 5.0 * asked) << share;
    EXPECT_GT(Domain().dot(x, work), 0.01 * asked) << share;
  }
}

TEST(Aggregates, AreWiderWhereTheyWouldBeTooMany) {
  const Lattice lattice(60);
  const auto aggregates = lattice.aggregates(1.0);
  EXPECT_LE(aggregates.size(), 256U);
  EXPECT_GT(aggregates.size(), 100U);
}

}  // namespace
}  // namespace poretwin
