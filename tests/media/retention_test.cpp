// Retention laws compared with their closed forms, and the properties that the flow solver needs.
#include "common/media/retention.hpp"

#include "common/media/brooks_corey.hpp"
#include "common/media/gardner.hpp"
#include "common/media/retention_table.hpp"
#include "common/media/van_genuchten.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

namespace poretwin::porous {
namespace {

std::unique_ptr<RetentionCurve> table_of(const RetentionCurve& curve) {
  Series saturation, permeability;
  for (const double h : {20.0, 10.0, 5.0, 3.0, 2.0, 1.5, 1.2, 1.0, 0.8, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.05}) {
    saturation.knots.emplace_back(-h, curve.saturation(-h).value);
    permeability.knots.emplace_back(-h, curve.permeability(-h).value);
  }
  saturation.knots.emplace_back(0.0, 1.0);
  permeability.knots.emplace_back(0.0, 1.0);
  return std::make_unique<RetentionTable>(saturation, permeability);
}

/// Curves of all laws, with the parameters of sands, loams and clays.
std::vector<std::pair<std::string, std::unique_ptr<RetentionCurve>>> all_curves() {
  std::vector<std::pair<std::string, std::unique_ptr<RetentionCurve>>> curves;
  curves.emplace_back("sand", std::make_unique<VanGenuchten>(3.5, 2.8, 0.0, 0.5));
  curves.emplace_back("coarse sand", std::make_unique<VanGenuchten>(14.5, 6.0, 0.0, 0.5));
  curves.emplace_back("loam", std::make_unique<VanGenuchten>(3.6, 1.56, 0.0, 0.5));
  curves.emplace_back("clay", std::make_unique<VanGenuchten>(0.8, 1.09, 0.0, 0.5));
  curves.emplace_back("loam, entry head", std::make_unique<VanGenuchten>(3.6, 1.56, 0.02, 0.5));
  curves.emplace_back("gardner", std::make_unique<Gardner>(10.0));
  curves.emplace_back("brooks and corey", std::make_unique<BrooksCorey>(0.3, 1.7));
  curves.emplace_back("table", table_of(VanGenuchten(3.5, 2.8, 0.0, 0.5)));
  return curves;
}

const std::vector<double> heads{-100.0, -30.0, -10.0, -3.0,   -1.0,  -0.7,  -0.31,
                                -0.29,  -0.1,  -0.03, -0.015, -4e-3, -5e-4, -1e-5};

TEST(Retention, VanGenuchtensClosedForm) {
  // Celia, Bouloutas & Zarba (1990): alpha 3.35, n 2, at -0.75 m, computed by hand: x = 2.5125^2.
  const VanGenuchten curve(3.35, 2.0, 0.0, 0.5);
  const double x = 2.5125 * 2.5125, s = std::pow(1.0 + x, -0.5);
  EXPECT_NEAR(curve.saturation(-0.75).value, s, 1e-14);
  EXPECT_NEAR(curve.permeability(-0.75).value, std::sqrt(s) * std::pow(1.0 - std::sqrt(1.0 - s * s), 2), 1e-14);
}

TEST(Retention, AnEntryHeadKeepsTheSoilFull) {
  const VanGenuchten curve(3.6, 1.56, 0.02, 0.5);
  EXPECT_EQ(curve.saturation(-0.0199).value, 1.0);
  EXPECT_EQ(curve.permeability(-0.0199).value, 1.0);
  EXPECT_NEAR(curve.saturation(-0.0201).value, 1.0, 1e-3);
  EXPECT_NEAR(curve.permeability(-0.0200001).value, 1.0, 1e-4);
  EXPECT_LT(curve.permeability(-0.1).value, 1.0);
}

TEST(Retention, BrooksAndCoreysClosedForm) {
  const BrooksCorey curve(0.3, 2.0);
  EXPECT_NEAR(curve.saturation(-0.6).value, 0.25, 1e-14);
  EXPECT_NEAR(curve.permeability(-0.6).value, std::pow(0.25, 4.0), 1e-14);
}

TEST(Retention, CurvesRiseAndTheirSlopesAreTheirDerivatives) {
  for (const auto& [name, curve] : all_curves()) {
    double before = 0.0, conducted_before = 0.0;
    for (const double psi : heads) {
      const Rate s = curve->saturation(psi), k = curve->permeability(psi);
      EXPECT_GE(s.value, before) << name << " at " << psi;
      EXPECT_GE(k.value, conducted_before) << name << " at " << psi;
      EXPECT_LE(k.value, 1.0) << name << " at " << psi;
      before = s.value;
      conducted_before = k.value;
      const double d = -1e-5 * psi;
      const auto slope = [&](auto f) { return (f(psi + d).value - f(psi - d).value) / (2.0 * d); };
      const double scale = 1.0 / -psi;
      EXPECT_NEAR(s.slope, slope([&](double x) { return curve->saturation(x); }), 1e-5 * scale)
          << name << " at " << psi;
      EXPECT_NEAR(k.slope, slope([&](double x) { return curve->permeability(x); }), 1e-5 * scale)
          << name << " at " << psi;
    }
  }
}

TEST(Retention, TheSwitchedVariableGoesThereAndBack) {
  for (auto& [name, curve] : all_curves()) {
    const Retention soil(std::move(curve));
    for (const double psi : {-30.0, -3.0, -1.0, -0.5, -0.31, -0.29, -0.1, -0.01, -1e-4, 0.0, 0.5, 10.0}) {
      const double u = soil.variable(psi);
      EXPECT_NEAR(soil.head(u).value, psi, 1e-7 * (1.0 + std::abs(psi))) << name;
      const double d = 1e-6 * u;
      EXPECT_NEAR(soil.head(u).slope, (soil.head(u + d).value - soil.head(u - d).value) / (2.0 * d),
                  1e-4 * soil.head(u).slope)
          << name << " at " << psi;
    }
  }
}

TEST(Retention, TheVariableIsTheSaturationWhereItRisesFaster) {
  const Retention sand(std::make_unique<VanGenuchten>(3.5, 2.8, 0.0, 0.5));
  EXPECT_DOUBLE_EQ(sand.variable(-2.0), sand.saturation(-2.0).value);
  // Above the joint u is linear in the head: equal steps.
  EXPECT_NEAR(sand.variable(0.2) - sand.variable(0.1), sand.variable(0.1) - sand.variable(0.0), 1e-14);
  EXPECT_GT(sand.variable(0.0), 1.0);  // continued with the slope at the joint, which is the largest
}

TEST(Retention, ThePotentialIsTheIntegralOfThePermeability) {
  // Gardner's: (exp(alpha psi) - 1) / alpha.
  const Retention gardner(std::make_unique<Gardner>(10.0));
  for (const double psi : heads) EXPECT_NEAR(gardner.potential(psi), std::expm1(10.0 * psi) / 10.0, 1e-10) << psi;
  EXPECT_EQ(gardner.potential(0.7), 0.7);
  // Brooks and Corey's: -h_e [1 + (1 - (h_e / |psi|)^(p - 1)) / (p - 1)], p = 3 lambda + 2.
  const Retention corey(std::make_unique<BrooksCorey>(0.3, 1.0));
  for (const double psi : {-0.2, -0.6, -3.0, -2e5}) {
    const double exact = psi > -0.3 ? psi : -0.3 * (1.0 + (1.0 - std::pow(0.3 / -psi, 4.0)) / 4.0);
    EXPECT_NEAR(corey.potential(psi), exact, 1e-5) << psi;
  }
}

TEST(Retention, NearlyFullSoilConductsAlongAStraightLine) {
  // For n < 2 the slope of k_r is infinite at psi = 0 (Vogel et al. 2001); over the last millimetre it is replaced.
  const VanGenuchten loam(3.6, 1.56, 0.0, 0.5);
  const double slope = loam.permeability(-1e-9).slope;
  EXPECT_NEAR(slope, (1.0 - loam.permeability(-1e-3).value) / 1e-3, 1e-6 * slope);
  EXPECT_LT(slope, 500.0);
  EXPECT_GT(slope, 50.0);
  // From n = 2 on the curve is unchanged.
  const VanGenuchten sand(3.6, 2.2, 0.0, 0.5);
  EXPECT_NEAR(sand.permeability(-5e-4).slope / sand.permeability(-1e-3).slope, std::pow(0.5, 0.2), 0.02);
}

TEST(Retention, ATableFollowsTheCurveThatItIsOf) {
  const VanGenuchten curve(3.5, 2.8, 0.0, 0.5);
  const auto table = table_of(curve);
  for (const double psi : {-15.0, -4.0, -0.9, -0.35, -0.15, -0.07}) {
    EXPECT_NEAR(table->saturation(psi).value, curve.saturation(psi).value, 0.01) << psi;
    EXPECT_NEAR(table->permeability(psi).value, curve.permeability(psi).value, 0.02) << psi;
  }
  // Beyond the ends of the table: a power of the suction, and saturated soil.
  EXPECT_NEAR(table->saturation(-100.0).value / curve.saturation(-100.0).value, 1.0, 0.1);
  EXPECT_EQ(table->saturation(0.0).value, 1.0);
}

/// A soil whose permeability rises from `least` to 1 over a millimetre of suction.
Retention jumping(double least) {
  const Series saturation{{{-2.0, 0.1}, {-0.5, 0.499}, {-0.001, 0.5}, {0.0, 1.0}}};
  const Series permeability{{{-2.0, 0.25 * least}, {-0.5, 0.5 * least}, {-0.201, least}, {-0.2, 1.0}}};
  return Retention(std::make_unique<RetentionTable>(saturation, permeability));
}

// Between two rows of even logarithms, which are 3 mm apart there, Phi would fall where k_r jumps.
TEST(Retention, ThePotentialRisesThroughAJumpOfThePermeability) {
  for (const double least : {0.2, 1e-3, 1e-6}) {
    const Retention soil = jumping(least);
    constexpr int steps = 40'000;
    constexpr double from = -0.25, to = -0.15, h = (to - from) / steps;
    double integral = 0.0;
    for (int k = 0; k < steps; ++k) {
      const double psi = from + (k + 0.5) * h;
      EXPECT_GT(soil.potential(psi + 0.5 * h), soil.potential(psi - 0.5 * h)) << psi;
      integral += h * soil.permeability(psi).value;
    }
    EXPECT_NEAR(soil.potential(to) - soil.potential(from), integral, 1e-6 * integral) << least;
  }
}

TEST(Retention, OfASoilFromItsKeys) {
  Soil soil;
  EXPECT_EQ(retention_of(soil), nullptr);
  soil.retention.emplace();
  EXPECT_EQ(retention_of(soil), nullptr);
  for (const auto& law : retention_laws())
    if (law.name == "gardner") soil.retention->law = &law;
  soil.retention->numbers["alpha"] = 2.0;
  soil.retention->residual_water_content = 0.1;
  soil.porosity = 0.4;
  ASSERT_NE(retention_of(soil), nullptr);
  EXPECT_NEAR(retention_of(soil)->saturation(-1.0).value, std::exp(-2.0), 1e-14);
  EXPECT_DOUBLE_EQ(residual_saturation(soil), 0.25);
}

}  // namespace
}  // namespace poretwin::porous
