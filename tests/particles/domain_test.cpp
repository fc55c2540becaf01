// What is formed over the ranks of a solver is the same as on one rank; a rank that decides by itself is found out.
#include "common/particles/domain.hpp"
#include "common/numerics/csr.hpp"
#include "tests/particles/ranks.hpp"

#include <gtest/gtest.h>

#include <random>

namespace poretwin {
namespace {

using test::Owned;
using test::ThreadRanks;

ScalarArray noise(std::size_t n, unsigned seed) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  ScalarArray values(n);
  for (double& value : values) value = any(generator);
  return values;
}

TEST(Domain, OfOneRankOwnsEverything) {
  const Domain domain;
  const ScalarArray a = noise(20000, 1), b = noise(20000, 2);
  EXPECT_EQ(domain.dot(a, b), one_rank::dot(a, b));
  EXPECT_EQ(domain.with_halo(7), 7U);
  EXPECT_EQ(domain.min(3.0), 3.0);
  EXPECT_TRUE(domain.any(true) && domain.all(true) && !domain.any(false) && !domain.all(false));
}

TEST(Domain, AsksAllRanks) {
  const ScalarArray whole = noise(1000, 3);
  const double most = *std::ranges::max_element(whole), least = *std::ranges::min_element(whole);
  ThreadRanks three(3);
  three.run([&](std::size_t rank, const Ranks& ranks) {
    const std::span<const double> own = std::span(whole).subspan(rank * 300, rank == 2 ? 400 : 300);
    const Domain domain(ranks, own.size(), 0);
    const auto value = [&](std::size_t i) { return own[i]; };
    EXPECT_NEAR(domain.dot(own, own), one_rank::dot(whole, whole), 1e-12);
    EXPECT_EQ(domain.max_over(own.size(), -2.0, value), most);
    EXPECT_EQ(domain.min(-one_rank::max_over(own.size(), -2.0, [&](std::size_t i) { return -own[i]; })), least);
    EXPECT_TRUE(domain.any_of(own.size(), [&](std::size_t i) { return own[i] == most; }));
    EXPECT_FALSE(domain.all_of(own.size(), [&](std::size_t i) { return own[i] > least; }));
    EXPECT_EQ(domain.sum(1.0), 3.0);
  });
}

/// A chain of springs of random stiffness between neighbours and to the ground, rows first .. last - 1 of n. Column j
/// of a row is entry place(j) of the vectors.
struct Chain {
  std::size_t n, first, last;
  std::vector<std::size_t> place;
  ScalarArray spring = noise(n + 1, 5), ground = noise(n, 6);
  [[nodiscard]] double between(std::size_t i) const { return 1.5 + spring[i]; }  // i - 1 and i
  void apply(std::span<const double> x, std::span<double> y) const {
    for (std::size_t i = first; i < last; ++i) {
      double sum = (between(i) + between(i + 1) + 1e-2 * (1.5 + ground[i])) * x[place[i]];
      if (i > 0) sum -= between(i) * x[place[i - 1]];
      if (i + 1 < n) sum -= between(i + 1) * x[place[i + 1]];
      y[i - first] = sum;
    }
  }
};

/// Solves the chain by conjugate gradients or GMRES on the rows that a domain owns.
template <bool by_gmres>
ScalarArray solve(const Domain& domain, const Chain& chain, std::span<const double> b, int& iterations) {
  const std::size_t rows = chain.last - chain.first;
  ScalarArray x(rows, 0.0), own(b.begin() + static_cast<std::ptrdiff_t>(chain.first),
                                b.begin() + static_cast<std::ptrdiff_t>(chain.last));
  const auto apply = [&](std::span<const double> u, std::span<double> y) { chain.apply(u, y); };
  const auto plain = [](std::span<const double> r, std::span<double> z) { std::copy(r.begin(), r.end(), z.begin()); };
  const double tolerance = 1e-14 * domain.norm(own);
  SolveReport report;
  if constexpr (by_gmres) {
    report = flexible_gmres(domain, apply, plain, own, x, tolerance, 200);
  } else {
    for (double& value : x) value = 0.1;  // a start other than zero is multiplied, too
    report = conjugate_gradients(domain, apply, plain, own, x, tolerance, 500);
  }
  EXPECT_TRUE(report.converged);
  iterations = report.iterations;
  return x;
}

template <bool by_gmres>
void expect_the_solution_of_one_rank() {
  constexpr std::size_t n = 120, cut = 50;
  const ScalarArray b = noise(n, 4);
  std::vector<std::size_t> place(n);
  for (std::size_t i = 0; i < n; ++i) place[i] = i;
  int iterations = 0;
  const ScalarArray whole = solve<by_gmres>({}, {n, 0, n, place}, b, iterations);
  EXPECT_GT(iterations, 20);
  // Each rank's halo is the particle next to the cut on the other side.
  ThreadRanks two(2, {{{1, 0}}, {{0, cut - 1}}});
  two.run([&](std::size_t rank, const Ranks& ranks) {
    const std::size_t first = rank == 0 ? 0 : cut, last = rank == 0 ? cut : n;
    std::vector<std::size_t> here(n, 0);
    for (std::size_t i = first; i < last; ++i) here[i] = i - first;
    here[rank == 0 ? cut : cut - 1] = last - first;
    const Domain domain(ranks, last - first, 1);
    int steps = 0;
    const ScalarArray part = solve<by_gmres>(domain, {n, first, last, here}, b, steps);
    EXPECT_LE(std::abs(steps - iterations), 2);
    for (std::size_t i = first; i < last; ++i) EXPECT_NEAR(part[i - first], whole[i], 1e-12) << i;
  });
}

TEST(Domain, ConjugateGradientsOnTwoRanksFindTheSolutionOfOne) { expect_the_solution_of_one_rank<false>(); }
TEST(Domain, GmresOnTwoRanksFindsTheSolutionOfOne) { expect_the_solution_of_one_rank<true>(); }

TEST(Domain, ARankThatDecidesByItselfIsFoundOut) {
  ThreadRanks two(2);
  const auto differ = [](std::size_t rank, const Ranks& ranks) {
    const Domain domain(ranks, 1, 0);
    double value = rank == 0 ? domain.sum(1.0) : 0.0;
    value += domain.max(1.0);
    EXPECT_TRUE(false) << value;
  };
  EXPECT_THROW(two.run(differ), std::runtime_error);
}

}  // namespace
}  // namespace poretwin
