// Modified Cam-Clay in laboratory tests, compared with tables and closed forms.
#include "solid_solver/material/element.hpp"
#include "tests/instructions.hpp"
#include "tests/solid/reference/table.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <random>

namespace poretwin::solid {
namespace {

using test::Table;

constexpr double lambda = 0.15, kappa = 0.03, slope = 1.0, preconsolidation = 1e5;

Soil clay(double ratio) {
  Soil soil;
  soil.poissons_ratio = 0.3;
  const double v = 2.5 - lambda * std::log(preconsolidation / 1e3) + kappa * std::log(ratio);
  soil.porosity = 1.0 - 1.0 / v;
  soil.own_numbers = {{"compression_slope", lambda},
                      {"swelling_slope", kappa},
                      {"critical_state_slope", slope},
                      {"overconsolidation_ratio", ratio},
                      {"preconsolidation_pressure", 0.0}};
  return soil;
}

std::unique_ptr<ConstitutiveModel> model_of(const Soil& soil) {
  return make_constitutive(MaterialName{"modified_cam_clay"}, soil);
}

Tensor from_all_sides(double pressure) {
  Tensor stress = Tensor::Zero();
  stress.head<3>().setConstant(-pressure);
  return stress;
}

/// Largest errors of p, q and pc over the largest p of the path, of the pore pressure [Pa] and of the void ratio.
struct Errors {
  double p = 0.0, q = 0.0, pc = 0.0, pore_pressure = 0.0, void_ratio = 0.0;
};

Errors errors_of(const Table& table, std::string_view name, double ratio, double step) {
  const LaboratoryTest& path = laboratory_test(name);
  const Soil soil = clay(ratio);
  const auto model = model_of(soil);
  Element sample(soil, *model, from_all_sides(preconsolidation / ratio));
  Errors errors;
  double reached = 0.0, largest = 0.0;
  for (std::size_t row = 0; row < table.size(); ++row) {
    if (table.word(row, "test") != name || table.number(row, "OCR") != ratio) continue;
    const double to = table.number(row, "strain");
    const auto steps = std::lround((to - reached) / step);
    for (long k = 0; k < steps; ++k)
      sample.strain_by(path, (path.shears ? 1.0 : -1.0) * (to - reached) / static_cast<double>(steps));
    reached = to;
    largest = std::max(largest, table.number(row, "p"));
    const auto off = [&](double& worst, double found, const char* column) {
      worst = std::max(worst, std::abs(found - table.number(row, column)));
    };
    off(errors.p, sample.pressure(), "p");
    off(errors.q, sample.deviator_stress(), "q");
    off(errors.pc, sample.state()[0], "pc");
    off(errors.pore_pressure, sample.excess_pore_pressure(path), "excess_pore_pressure");
    off(errors.void_ratio, sample.void_ratio(), "e");
  }
  for (double* error : {&errors.p, &errors.q, &errors.pc}) *error /= largest;
  return errors;
}

TEST(CamClay, FollowsTheTables) {
  const Table table = Table::read("cam_clay.csv");
  for (const LaboratoryTest& path : laboratory_tests()) {
    if (path.name == "isotropic") continue;
    for (const double ratio : {1.0, 1.5, 5.0}) {
      const Errors coarse = errors_of(table, path.name, ratio, 1e-4), fine = errors_of(table, path.name, ratio, 2.5e-5);
      const std::string where =
          fmt::format("{} OCR {}: p {:.1e} {:.1e}, q {:.1e} {:.1e}, pc {:.1e}, u {:.0f} Pa", path.name, ratio, coarse.p,
                      fine.p, coarse.q, fine.q, coarse.pc, coarse.pore_pressure);
      RecordProperty(fmt::format("{}_{}", path.name, ratio), where);
      EXPECT_LT(coarse.p, 2e-3) << where;
      EXPECT_LT(coarse.q, 2e-3) << where;
      EXPECT_LT(coarse.pc, 2e-3) << where;
      EXPECT_LT(coarse.pore_pressure, 300.0) << where;
      EXPECT_LT(coarse.void_ratio, 1e-3) << where;
      EXPECT_LT(fine.p, std::max(0.4 * coarse.p, 1e-6)) << where;
      EXPECT_LT(fine.q, std::max(0.4 * coarse.q, 1e-6)) << where;
    }
  }
}

// At constant volume p^kappa pc^(lambda - kappa) is constant, and at the critical state p = pc / 2 and q = M p: p = p0
// (OCR / 2)^(1 - kappa / lambda).
TEST(CamClay, EndsAtTheCriticalStateOfItsVolume) {
  for (const double ratio : {1.0, 1.5, 5.0}) {
    const Soil soil = clay(ratio);
    const auto model = model_of(soil);
    const double p0 = preconsolidation / ratio;
    Element sample(soil, *model, from_all_sides(p0));
    for (int k = 0; k < 6000; ++k) sample.strain_by(laboratory_test("triaxial_undrained"), -1e-4);
    const double right = p0 * std::pow(0.5 * ratio, 1.0 - kappa / lambda);
    EXPECT_NEAR(sample.pressure(), right, 1e-4 * right);
    EXPECT_NEAR(sample.deviator_stress(), slope * right, 1e-4 * right);
  }
}

// Normal compression without lateral strain ends at a constant eta = q / p: two thirds of the volumetric strain are the
// shear strain, of which eta kappa / (3 (G / K) lambda) is elastic and (1 - kappa / lambda) 2 eta / (M^2 - eta^2)
// plastic.
TEST(CamClay, TheOedometerEndsAtItsRatioOfStresses) {
  const Soil soil = clay(1.0);
  const auto model = model_of(soil);
  Element sample(soil, *model, from_all_sides(preconsolidation));
  for (int k = 0; k < 5000; ++k) sample.strain_by(laboratory_test("oedometer"), -1e-4);
  constexpr double shear_ratio = 1.5 * 0.4 / 1.3;
  double low = 0.0, high = slope;
  for (int k = 0; k < 60; ++k) {
    const double eta = 0.5 * (low + high);
    const double shear =
        eta * kappa / (3.0 * shear_ratio * lambda) + (1.0 - kappa / lambda) * 2.0 * eta / (slope * slope - eta * eta);
    (shear < 2.0 / 3.0 ? low : high) = eta;
  }
  const double at_rest = (3.0 - low) / (3.0 + 2.0 * low);
  EXPECT_NEAR(at_rest, 0.72216, 1e-5);
  EXPECT_NEAR(sample.stress()[0] / sample.stress()[1], at_rest, 1e-4 * at_rest);
}

TEST(CamClay, IsotropicCompressionFollowsTheTwoLines) {
  const Soil soil = clay(2.0);
  const auto model = model_of(soil);
  Element sample(soil, *model, from_all_sides(0.5 * preconsolidation));
  const double v0 = 1.0 + sample.void_ratio();
  const LaboratoryTest& path = laboratory_test("isotropic");
  for (int k = 1; k <= 100; ++k) sample.load_to(path, -(5e4 + 5e2 * k));
  EXPECT_NEAR(1.0 + sample.void_ratio(), v0 - kappa * std::log(2.0), 1e-5);
  for (int k = 1; k <= 200; ++k) sample.load_to(path, -(1e5 + 5e2 * k));
  const double loaded = v0 - kappa * std::log(2.0) - lambda * std::log(2.0);
  EXPECT_NEAR(1.0 + sample.void_ratio(), loaded, 1e-5);
  for (int k = 1; k <= 100; ++k) sample.load_to(path, -(2e5 - 1e3 * k));
  EXPECT_NEAR(1.0 + sample.void_ratio(), loaded + kappa * std::log(2.0), 1e-5);
}

TEST(CamClay, LargeStepsEndWhereSmallOnesDo) {
  for (const double ratio : {1.0, 5.0}) {
    const Soil soil = clay(ratio);
    const auto model = model_of(soil);
    for (const auto* name : {"triaxial_undrained", "simple_shear_undrained", "oedometer"}) {
      Element small(soil, *model, from_all_sides(preconsolidation / ratio)), large = small;
      const LaboratoryTest& path = laboratory_test(name);
      const double to = path.shears ? 0.1 : -0.1;
      for (int k = 0; k < 4000; ++k) small.strain_by(path, to / 4000);
      for (int k = 0; k < 2; ++k) large.strain_by(path, to / 2);
      EXPECT_NEAR(large.pressure(), small.pressure(), 0.02 * small.pressure()) << name;
      EXPECT_NEAR(large.deviator_stress(), small.deviator_stress(), 0.02 * small.pressure()) << name;
    }
  }
}

TEST(CamClay, BearsNoTensionAndKeepsTheLeastOfItsStrength) {
  const Soil soil = clay(1.0);
  const auto model = model_of(soil);
  std::vector<double> state(2);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int k = 0; k < 300; ++k) {
    Tensor stress = from_all_sides(k % 3 == 0 ? 0.0 : 2e3);
    model->initial(stress, state);
    for (int n = 0; n < 20; ++n) {
      Tensor strain;
      for (int c = 0; c < 6; ++c) strain[c] = (k % 2 == 0 ? 2e-2 : 1e-3) * any(random) + (c < 3 ? 5e-3 : 0.0);
      model->advance(stress, strain, {0.0, 0.8}, state);
      ASSERT_TRUE(stress.allFinite());
      EXPECT_GE(-trace(stress) / 3.0, -1e-3 * soil.least_pressure);
      EXPECT_GE(state[0], soil.least_pressure);
    }
  }
}

TEST(CamClay, FourAtATimeIsAsOneByOne) {
  const Soil soil = clay(1.5);
  const auto model = model_of(soil);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  std::size_t yielded = 0, n = 0;
  test::with_each_instruction_set([&] {
    for (int k = 0; k < 300; ++k) {
      Four four;
      std::array<Quad, 2> together;
      four.state = together.data();
      std::array<Tensor, n_lanes> stress;
      std::array<std::array<double, 2>, n_lanes> state;
      std::array<double, n_lanes> plastic;
      // Of equal size, since the largest strain decides for all four into how many steps it is divided.
      const double size = std::pow(10.0, -5.0 + any(random));
      for (std::size_t l = 0; l < n_lanes; ++l) {
        const double mean = -1e4 - 1e4 * std::abs(any(random));
        Tensor strain;
        for (int c = 0; c < 6; ++c) {
          stress[l][c] = (c < 3 ? mean : 0.0) + 0.1 * mean * any(random);
          strain[c] = size * any(random);
        }
        model->initial(stress[l], state[l]);
        const double looser = 0.8 + 0.2 * any(random);
        for (int c = 0; c < 6; ++c) {
          four.stress[c][l] = stress[l][c];
          four.strain[c][l] = strain[c];
        }
        for (std::size_t s = 0; s < 2; ++s) together[s].v[l] = state[l][s] *= s == 0 && k % 2 == 0 ? 1.0 / 1.5 : 1.0;
        four.saturation[l] = 0.0;
        four.void_ratio[l] = looser;
        plastic[l] = model->advance(stress[l], strain, {0.0, looser}, state[l]);
        yielded += plastic[l] > 0.0 ? 1 : 0;
      }
      model->advance(std::span(&four, 1));
      for (std::size_t l = 0; l < n_lanes; ++l, ++n) {
        EXPECT_NEAR(four.plastic[l], plastic[l], 1e-7 * size);
        for (std::size_t s = 0; s < 2; ++s) EXPECT_NEAR(together[s].v[l], state[l][s], 1e-8 * state[l][s]);
        for (int c = 0; c < 6; ++c) EXPECT_NEAR(four.stress[c][l], stress[l][c], 1e-8 * stress[l].norm());
      }
    }
  });
  EXPECT_GT(yielded, n / 5);
  EXPECT_LT(yielded, n * 4 / 5);
}

}  // namespace
}  // namespace poretwin::solid
