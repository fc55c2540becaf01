// Conjugate gradients are judged by the residual of their result.
#include "common/numerics/csr.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace poretwin {
namespace {

/// y = A x for a ring of points, each joined to the next; sums of rows and columns are zero.
void multiply(std::span<const double> x, std::span<double> y) {
  const std::size_t n = x.size();
  std::fill(y.begin(), y.end(), 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = (i + 1) % n;
    const double flow = (1.0 + 0.37 * std::sin(static_cast<double>(i))) * (x[j] - x[i]);
    y[i] -= flow;
    y[j] += flow;
  }
}

double residual_of(const ScalarArray& b, const ScalarArray& x) {
  ScalarArray left(b.size());
  multiply(x, left);
  for (std::size_t i = 0; i < b.size(); ++i) left[i] = b[i] - left[i];
  return Domain().norm(left);
}

/// From a start far along the direction in which A is singular, rounding parts the residual that the iteration carries
/// along from that of x.
TEST(ConjugateGradients, TheResidualOfTheResultDecides) {
  constexpr std::size_t n = 40;
  ScalarArray b(n);
  double mean = 0.0;
  for (std::size_t i = 0; i < n; ++i) mean += (b[i] = std::sin(3.0 + std::pow(static_cast<double>(i), 1.3))) / n;
  for (double& value : b) value -= mean;
  const auto plain = [](std::span<const double> r, std::span<double> z) { std::copy(r.begin(), r.end(), z.begin()); };
  int deceived = 0;
  for (const double start : {0.0, 1e5, 3e5, 1e6, 3e6, 1e7}) {
    SCOPED_TRACE(start);
    const double tolerance = 3e-10 * Domain().norm(b);
    ScalarArray x(n, start), carried(n, start), r(n);
    multiply(x, r);
    for (std::size_t i = 0; i < n; ++i) r[i] = b[i] - r[i];
    const bool by_iteration = reduce_residual(Domain(), multiply, plain, r, carried, tolerance, 500).converged;
    deceived += by_iteration && residual_of(b, carried) > tolerance ? 1 : 0;
    const auto report = conjugate_gradients(Domain(), multiply, plain, b, x, tolerance, 500);
    EXPECT_EQ(report.converged, residual_of(b, x) <= tolerance);
    EXPECT_DOUBLE_EQ(report.residual, residual_of(b, x));
    EXPECT_TRUE(report.converged || start > 0.0);
  }
  EXPECT_GT(deceived, 0);
}

}  // namespace
}  // namespace poretwin
