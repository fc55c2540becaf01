// Seepage laws compared with numbers computed by hand.
#include "common/media/seepage.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace poretwin::porous {
namespace {

Soil rockfill() {
  Soil soil;
  soil.porosity = 0.4052;
  soil.seepage_law = &seepage_law("ergun");
  soil.own_numbers["grain_diameter"] = 0.03504;
  return soil;
}

TEST(SeepageLaw, ErgunsCoefficientsOfTheRockfill) {
  // Computed by hand from Eqs. (91), (92) as corrected: i = 0.066226 U + 45.516 U^2.
  const auto law = seepage_at(Case{}, rockfill(), 0.4052);
  EXPECT_NEAR(1.0 / law.conductivity, 0.066226, 1e-5);
  EXPECT_NEAR(law.quadratic, 45.516, 5e-3);
}

TEST(SeepageLaw, ErgunInTheFormOfEquation91) {
  const double n = 0.35, g = 9.81, rho = 1000.0, mu = 1e-3;
  const double kappa = n * n * n * std::pow(0.03504, 2) / (150.0 * (1.0 - n) * (1.0 - n));
  const auto R = resistance(rho * g, n, seepage_at(Case{}, rockfill(), n));
  EXPECT_NEAR(R.linear / (n * n * mu / kappa), 1.0, 1e-12);
  EXPECT_NEAR(R.quadratic / (1.75 / std::sqrt(150.0) * rho * std::pow(n, 1.5) / std::sqrt(kappa)), 1.0, 1e-12);
}

TEST(SeepageLaw, UsersCoefficientsScaleAsErguns) {
  auto ergun = rockfill(), user = rockfill();
  const auto there = seepage_at(Case{}, ergun, 0.4052);
  user.seepage_law = &seepage_law("forchheimer");
  user.hydraulic_conductivity = there.conductivity;
  user.own_numbers["forchheimer_coefficient"] = there.quadratic;
  for (const double n : {0.3, 0.4052, 0.45}) {
    const auto a = seepage_at(Case{}, ergun, n), b = seepage_at(Case{}, user, n);
    EXPECT_NEAR(a.conductivity / b.conductivity, 1.0, 1e-12);
    EXPECT_NEAR(a.quadratic / b.quadratic, 1.0, 1e-12);
  }
}

TEST(SeepageLaw, DarcyFollowsKozenyCarmanAndConstantDoesNot) {
  Soil sand;
  sand.porosity = 0.4;
  sand.hydraulic_conductivity = 1e-4;
  EXPECT_NEAR(seepage_at(Case{}, sand, 0.5).conductivity, 1e-4 * (0.125 / 0.25) / (0.064 / 0.36), 1e-16);
  EXPECT_NEAR(resistance(9810.0, 0.4, seepage_at(Case{}, sand, 0.4)).linear, 9810.0 * 0.16 / 1e-4, 1e-3);
  sand.seepage_law = &seepage_law("constant");
  EXPECT_EQ(seepage_at(Case{}, sand, 0.5).conductivity, 1e-4);
}

TEST(SeepageLaw, ResistanceFadesIntoFreeWater) {
  const auto free = resistance(9810.0, 1.0, carried_over({1e-2, 40.0}, 0.4, 1.0));
  EXPECT_EQ(free.linear, 0.0);
  EXPECT_EQ(free.quadratic, 0.0);
}

TEST(SeepageLaw, SpeedInvertsTheLaw) {
  for (const Resistance& r : {Resistance{10.0, 0.0}, Resistance{10.0, 300.0}, Resistance{0.0, 300.0}}) {
    const double w = 0.37, force = (r.linear + r.quadratic * w) * w;
    EXPECT_NEAR(r.speed(force), w, 1e-12);
    EXPECT_NEAR((r.linear + r.quadratic * (w + 1e-6)) * (w + 1e-6) - force, 1e-6 * r.slope(w), 1e-9);
  }
  EXPECT_EQ((Resistance{}.speed(0.0)), 0.0);
}

}  // namespace
}  // namespace poretwin::porous
