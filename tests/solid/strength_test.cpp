// Keys of strength and stiffness in laboratory tests: softening, undrained strength, pressure-dependent stiffness; and
// how the tests themselves end.
#include "common/core/error.hpp"
#include "solid_solver/material/cone.hpp"
#include "solid_solver/material/element.hpp"
#include "tests/solid/reference/table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

namespace poretwin::solid {
namespace {

using test::Table;
using testing::HasSubstr;

Soil soil_of(double cohesion, double phi) {
  Soil soil;
  soil.youngs_modulus = 2e6;
  soil.poissons_ratio = 0.3;
  soil.cohesion = cohesion;
  soil.friction_angle = phi;
  soil.band_width = 0.01;
  return soil;
}

Tensor from_all_sides(double pressure) {
  Tensor stress = Tensor::Zero();
  stress.head<3>().setConstant(-pressure);
  return stress;
}

TEST(Softening, FollowsTheClosedFormInSimpleShear) {
  Soil soil = soil_of(1e3, 35.0);
  soil.residual_cohesion = 200.0;
  soil.residual_friction_angle = 28.0;
  soil.softening_slip = 0.1 * soil.band_width;
  const auto model = make_constitutive(MaterialName::mohr_coulomb, soil);
  const Table table = Table::read("softening_simple_shear.csv");
  double worst[2] = {0.0, 0.0};
  for (const int finer : {0, 1}) {
    Element sample(soil, *model, from_all_sides(1e4));
    double reached = 0.0;
    for (std::size_t row = 0; row < table.size(); ++row) {
      const double to = table.number(row, "gamma"), step = finer ? 5e-5 : 1e-4;
      const auto steps = std::lround((to - reached) / step);
      for (long k = 0; k < steps; ++k)
        sample.strain_by(laboratory_test("simple_shear_undrained"), (to - reached) / static_cast<double>(steps));
      reached = to;
      const double tau = table.number(row, "tau");
      worst[finer] = std::max(worst[finer], std::abs(sample.stress()[3] - tau) / tau);
      EXPECT_NEAR(sample.state()[0], table.number(row, "plastic"), 5e-4) << reached;
    }
  }
  EXPECT_LT(worst[0], 5e-3);
  EXPECT_LT(worst[1], 0.6 * worst[0]);
}

// A band one particle wide in series with elastic soil: the layer's strength and dissipation depend on the slip, not on
// the band's width.
TEST(Softening, OfABandDoesNotDependOnItsWidth) {
  constexpr double height = 0.2, shear = 2e6 / 2.6;
  const Table table = Table::read("softening_band.csv");
  for (const double width : {0.02, 0.01, 0.005}) {
    Soil soil = soil_of(2e3, 0.0);
    soil.residual_cohesion = 500.0;
    soil.softening_slip = 0.01;
    soil.band_width = width;
    const auto model = make_constitutive(MaterialName::mohr_coulomb, soil);
    Element band(soil, *model, from_all_sides(1e4));
    std::size_t row = 0;
    double dissipated = 0.0, last = 0.0, last_tau = 0.0;
    for (int k = 1; k <= 40000 && row < table.size(); ++k) {
      band.strain_by(laboratory_test("simple_shear_undrained"), 1e-6 / width);
      const double tau = band.stress()[3], gamma = 2.0 * band.strain()[3];
      const double displacement = gamma * width + (height - width) * tau / shear, slip = (gamma - tau / shear) * width;
      dissipated += 0.5 * (tau + last_tau) * (slip - last);
      last = slip;
      last_tau = tau;
      if (displacement < table.number(row, "displacement")) continue;
      EXPECT_NEAR(tau, table.number(row, "tau"), 5e-3 * table.number(row, "tau")) << width << " m, " << displacement;
      ++row;
    }
    EXPECT_EQ(row, table.size());
    EXPECT_NEAR(dissipated, 12.5 + 500.0 * (last - 0.01), 5e-3 * dissipated) << width;  // with residual strength
  }
}

TEST(Softening, OfDilationEndsIt) {
  Soil soil = soil_of(0.0, 30.0);
  soil.dilation_angle = 10.0;
  soil.residual_dilation_angle = 0.0;
  soil.softening_slip = 0.05 * soil.band_width;
  const auto model = make_constitutive(MaterialName::mohr_coulomb, soil);
  Element sample(soil, *model, from_all_sides(1e4));
  const LaboratoryTest& path = laboratory_test("simple_shear");
  for (int k = 0; k < 2000; ++k) sample.strain_by(path, 1e-4);
  const double volume = trace(sample.strain());
  EXPECT_GT(volume, 1e-3);
  for (int k = 0; k < 500; ++k) sample.strain_by(path, 1e-4);
  EXPECT_NEAR(trace(sample.strain()), volume, 1e-9);
}

TEST(Stiffness, FollowsThePressureInEveryMaterial) {
  for (const char* name : {"elastic", "drucker_prager", "drucker_prager_rate", "mohr_coulomb"}) {
    Soil soil = soil_of(1e5, 30.0);
    soil.stiffness_exponent = 0.5;
    const auto model = make_constitutive(MaterialName{name}, soil);
    Element sample(soil, *model, from_all_sides(2e4));
    for (int k = 0; k < 200; ++k) sample.load_to(laboratory_test("isotropic"), -(2e4 + 4e2 * (k + 1)));
    // d p = K (p / 100 kPa)^(1/2) d e: 2 (sqrt(p) - sqrt(p0)) = K e / sqrt(100 kPa).
    const double bulk = 2e6 / 1.2, strain = 2.0 * (std::sqrt(1e5) - std::sqrt(2e4)) * std::sqrt(1e5) / bulk;
    EXPECT_NEAR(-trace(sample.strain()), strain, 1e-5 * strain) << name;
    const std::vector<double> none(model->state_size());
    EXPECT_NEAR(model->moduli(from_all_sides(4e5), none).bulk, 2.0 * bulk, 1e-9 * bulk) << name;
    EXPECT_NEAR(model->moduli(from_all_sides(0.0), none).bulk, 0.1 * bulk, 1e-9 * bulk) << name;  // at 1 kPa
    EXPECT_NEAR(model->stiffest(4e5).bulk, 2.0 * bulk, 1e-9 * bulk) << name;
  }
}

TEST(Strength, IsDividedBeforeAndAfterSoftening) {
  Soil soil = soil_of(1e3, 30.0);
  soil.residual_cohesion = 400.0;
  soil.residual_friction_angle = 20.0;
  soil.softening_slip = 0.01;
  const Soil half = weakened(soil, 2.0);
  const auto tangent = [](double degrees) { return std::tan(degrees * std::numbers::pi / 180.0); };
  EXPECT_DOUBLE_EQ(half.cohesion, 500.0);
  EXPECT_DOUBLE_EQ(*half.residual_cohesion, 200.0);
  EXPECT_NEAR(tangent(half.friction_angle), 0.5 * tangent(30.0), 1e-12);
  EXPECT_NEAR(tangent(*half.residual_friction_angle), 0.5 * tangent(20.0), 1e-12);
}

Case case_with(const std::string& keys, const std::string& model = "mohr_coulomb") {
  const auto path = std::filesystem::temp_directory_path() / "poretwin_strength.toml";
  std::ofstream(path) << "[case]\nend_time = 1\n[solid]\nmodel = \"" << model
                      << "\"\nparticle_spacing = 0.05\n[[soil]]\n"
                         "min = [0, 0]\nmax = [1, 1]\n"
                      << keys << "\n[[wall]]\npoints = [[0, 2], [0, 0], [1, 0], [1, 2]]\n";
  return read_case(path);
}

std::string complaint(const std::string& keys, const std::string& model = "mohr_coulomb") {
  try {
    case_with(keys, model);
  } catch (const CaseError& error) {
    return error.what();
  }
  return "";
}

TEST(Strength, UndrainedIsCohesionWithoutFrictionAndWithoutTension) {
  const Soil soil = case_with("undrained_shear_strength = 20e3").soils[0];
  const auto model = make_constitutive(MaterialName::mohr_coulomb, soil);
  Element sample(soil, *model, from_all_sides(1e5));
  for (int k = 0; k < 400; ++k) sample.strain_by(laboratory_test("triaxial_undrained"), -1e-4);
  EXPECT_NEAR(sample.deviator_stress(), 40e3, 1e-3);
  Tensor stress = Tensor::Zero();
  model->advance(stress, Tensor::Constant(1e-3));
  EXPECT_NEAR(stress.norm(), 0.0, 1e-6);
}

TEST(Strength, IsJudgedByTheCheck) {
  EXPECT_THAT(complaint("undrained_shear_strength = 20e3\ncohesion = 10"),
              HasSubstr("'soil[0].cohesion': expected none beside undrained_shear_strength"));
  EXPECT_THAT(complaint("dilation_angle = 31"),
              HasSubstr("'soil[0].dilation_angle': expected at most the friction angle"));
  EXPECT_THAT(complaint("residual_friction_angle = 31\nsoftening_slip = 0.1"),
              HasSubstr("expected at most friction_angle"));
  EXPECT_THAT(complaint("residual_friction_angle = 20"), HasSubstr("'soil[0].softening_slip': expected the slip"));
  EXPECT_THAT(complaint("residual_friction_angle = 20\nsoftening_slip = 0.1", "drucker_prager"),
              HasSubstr("\"drucker_prager\" keeps its strength"));
  const std::string clay = "earth_pressure_at_rest = 0.6\n";
  EXPECT_EQ(complaint(clay, "modified_cam_clay"), "");
  EXPECT_THAT(complaint("", "modified_cam_clay"), HasSubstr("'soil[0].earth_pressure_at_rest': soil.model = "));
  EXPECT_THAT(complaint(clay + "critical_state_slope = 0", "modified_cam_clay"),
              HasSubstr("'soil[0].critical_state_slope': expected a number > 0, found 0"));
  EXPECT_THAT(complaint(clay + "overconsolidation_ratio = 0.9", "modified_cam_clay"),
              HasSubstr("'soil[0].overconsolidation_ratio': expected a number >= 1, found 0.9"));
  EXPECT_THAT(complaint(clay + "swelling_slope = 0.2", "modified_cam_clay"),
              HasSubstr("'soil[0].swelling_slope': expected less than the compression slope of 0.1"));
  const std::string grains = "grain_diameter = 1e-3\n";
  EXPECT_EQ(complaint(grains, "mu_i"), "");
  EXPECT_THAT(complaint("", "mu_i"), HasSubstr("'soil[0].grain_diameter': soil.model = \"mu_i\" needs it"));
  EXPECT_THAT(complaint("grain_diameter = -1", "mu_i"), HasSubstr("'soil[0].grain_diameter': expected a number >= 0"));
  EXPECT_THAT(complaint(grains, "mohr_coulomb"), HasSubstr("'soil[0].grain_diameter': belongs to seepage_law"));
  EXPECT_THAT(complaint(grains + "limiting_friction = 0.3", "mu_i"),
              HasSubstr("'soil[0].limiting_friction': expected at least the static friction of 0.38, found 0.3"));
  EXPECT_THAT(complaint(grains + "inertial_number = 0", "mu_i"),
              HasSubstr("'soil[0].inertial_number': expected a number > 0"));
  EXPECT_THAT(complaint(grains + "critical_solid_fraction = 1", "mu_i"),
              HasSubstr("'soil[0].critical_solid_fraction': expected a number in (0, 1)"));
  EXPECT_THAT(complaint(grains + "dilatancy = 4\ncritical_solid_fraction = 0.75", "mu_i"),
              HasSubstr("'soil[0].dilatancy': the solid fraction of 0.6 lies so far below the critical one"));
}

// Coulomb: s1 = s3 tan^2(45 + phi/2) + 2 c tan(45 + phi/2), in triaxial compression as in plane strain; volume by the
// flow rule, d ev / d e1 = 1 - (1 + sin psi) / (1 - sin psi).
TEST(Element, CompressionEndsAtCoulombsStrengthAndDilatesByTheFlowRule) {
  Soil soil = soil_of(500.0, 30.0);
  soil.dilation_angle = 10.0;
  const auto model = make_constitutive(MaterialName::mohr_coulomb, soil);
  const double sine = std::sin(10.0 * std::numbers::pi / 180.0);
  for (const char* name : {"triaxial", "plane_strain"}) {
    const LaboratoryTest& path = laboratory_test(name);
    Element sample(soil, *model, from_all_sides(1e4));
    for (int k = 0; k < 500; ++k) sample.strain_by(path, -1e-4);
    EXPECT_NEAR(sample.stress()[1], -(3e4 + 1e3 * std::sqrt(3.0)), 1e-3) << name;
    EXPECT_NEAR(sample.stress()[0], -1e4, 1e-4) << name;
    const double before = trace(sample.strain());
    for (int k = 0; k < 10; ++k) sample.strain_by(path, -1e-4);
    EXPECT_NEAR(trace(sample.strain()) - before, 1e-3 * ((1.0 + sine) / (1.0 - sine) - 1.0), 1e-9) << name;
    EXPECT_EQ(sample.excess_pore_pressure(path), 0.0);
  }
}

TEST(Element, SaysWhereTheSoilBearsNoMore) {
  const Soil soil = soil_of(500.0, 30.0);
  const auto model = make_constitutive(MaterialName::mohr_coulomb, soil);
  Element sample(soil, *model, from_all_sides(1e4));
  const LaboratoryTest& path = laboratory_test("triaxial");
  sample.load_to(path, -3e4);
  EXPECT_NEAR(sample.strain()[1], -2e4 / 2e6, 1e-9);
  const Tensor before = sample.stress();
  try {
    sample.load_to(path, -4e4);
    ADD_FAILURE() << "borne";
  } catch (const DivergedError& error) {
    EXPECT_THAT(error.what(), HasSubstr("the soil bears no more"));
  }
  EXPECT_EQ(sample.stress(), before);
}

}  // namespace
}  // namespace poretwin::solid
