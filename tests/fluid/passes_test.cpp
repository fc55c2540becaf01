// Repeated passes through a window: the values from which the next pass departs.
#include "fluid_solver/exchange/passes.hpp"

#include <gtest/gtest.h>

#include <array>

namespace poretwin::fluid {
namespace {

/// Three independent modes. The skeleton has the stiffness T, predicted as A, and the water pushes it by c - D s when
/// its velocity is s. Both agree at c / (T + D). Plain repetition multiplies an error by -(A - T) D / ((A + D) T).
struct Modes {
  std::array<double, 3> T{1.0, 0.2, 3.0}, A{1.0, 4.0, 4.0}, D{0.5, 2.0, 9.0}, c{1.0, -2.0, 0.7};
};

/// Number of passes until the largest departure is small; at most 50.
int passes_to_agree(const Modes& m) {
  Passes<2> passes;
  VecArray<2> predicted(3, Vec<2>::Zero()), force(3, Vec<2>::Zero());
  std::array<double, 3> u{};
  for (unsigned pass = 0; pass < 50; ++pass) {
    SoilView<2> view;
    view.resize(3);
    view.mask.assign(3, 1.0);
    if (pass > 0)
      for (auto* values : {&view.found_velocity, &view.found_force}) values->allocate(3);
    // The soil is in equilibrium with the force of the water that it received: no unbalanced force.
    for (std::size_t i = 0; i < 3 && pass > 0; ++i) view.found_velocity.set(i, {u[i], 0.0});
    passes.begin(pass, view);
    double worst = 0.0;
    OrZero<Vec<2>> skeleton, given;
    skeleton.allocate(3);
    given.allocate(3);
    for (std::size_t i = 0; i < 3; ++i) {
      // (A + D) s = A u + F + c: the prediction for the departure from what was found.
      const double s = (m.A[i] * view.found_velocity[i][0] + view.found_force[i][0] + m.c[i]) / (m.A[i] + m.D[i]);
      const double f = m.c[i] - m.D[i] * s;
      skeleton.set(i, {s, 0.0});
      given.set(i, {f, 0.0});
      u[i] = f / m.T[i];
      worst = std::max(worst, std::abs(u[i] - s));
    }
    passes.end(ScalarArray(3, 0.0), skeleton, given);
    if (worst < 1e-9) {
      for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(u[i], m.c[i] / (m.T[i] + m.D[i]), 1e-9);
      return static_cast<int>(pass) + 1;
    }
  }
  return 50;
}

TEST(Passes, ARightPredictionAgreesInTwo) {
  Modes m;
  m.T = m.A;
  EXPECT_LE(passes_to_agree(m), 2);
}

TEST(Passes, ThreeSoftModesAgreeInFiveThoughRepeatedAsTheyAreTheyGrow) {
  const Modes m;
  EXPECT_GT((m.A[1] - m.T[1]) * m.D[1] / ((m.A[1] + m.D[1]) * m.T[1]), 1.0);
  EXPECT_LE(passes_to_agree(m), 5);
}

TEST(Passes, AFirstPassKnowsNothing) {
  Passes<2> passes;
  SoilView<2> view;
  view.resize(1);
  view.mask = {1.0};
  view.found_velocity.set(0, {1.0, 0.0}, 1);
  passes.begin(0, view);
  EXPECT_FALSE(view.found_velocity.is_allocated());
  EXPECT_TRUE(passes.pressure().empty());
}

}  // namespace
}  // namespace poretwin::fluid
