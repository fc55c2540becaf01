// Kernels are normalised, and their derivatives are those of their values.
#include "common/particles/kernel.hpp"

#include <gtest/gtest.h>

namespace poretwin::sph {
namespace {

template <int D>
double shell(double r) {
  return D == 2 ? 2.0 * std::numbers::pi * r : 4.0 * std::numbers::pi * r * r;
}

template <int D, template <int> class K>
void check() {
  const double h = 0.37;
  const int n = 20000;
  double integral = 0.0;
  for (int i = 0; i < n; ++i) {
    const double r = (i + 0.5) * support_radius * h / n;
    integral += K<D>::value(r, h) * shell<D>(r) * support_radius * h / n;
  }
  EXPECT_NEAR(integral, 1.0, 1e-6);
  for (const double q : {0.1, 0.6, 1.0, 1.4, 1.9}) {
    const double r = q * h, step = 1e-5 * h;
    const double slope = (K<D>::value(r + step, h) - K<D>::value(r - step, h)) / (2.0 * step);
    EXPECT_NEAR(K<D>::derivative_over_r(r, h) * r, slope, 1e-4 * K<D>::value(0, h) / h);
  }
  EXPECT_EQ(K<D>::value(2.0 * h, h), 0.0);
  EXPECT_EQ(K<D>::derivative_over_r(2.1 * h, h), 0.0);
}

TEST(Kernel, CubicSplineIsNormalisedAndConsistent) {
  check<2, CubicSpline>();
  check<3, CubicSpline>();
}
TEST(Kernel, WendlandIsNormalisedAndConsistent) {
  check<2, WendlandC2>();
  check<3, WendlandC2>();
}

}  // namespace
}  // namespace poretwin::sph
