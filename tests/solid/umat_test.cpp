// A user's own model from a shared library: the two examples of docs/extending, and libraries that fail.
#include "common/core/error.hpp"
#include "solid_solver/material/model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <string>

namespace poretwin::solid {
namespace {

using testing::HasSubstr;

constexpr double youngs = 1e7, poisson = 0.3, strength = 5e3;

Soil user_soil(const std::string& library) {
  Soil soil;
  soil.youngs_modulus = youngs;
  soil.poissons_ratio = poisson;
  soil.library = library;
  soil.properties = {youngs, poisson, strength};
  soil.state_variables = 1;
  return soil;
}

/// Compares the example with Drucker-Prager without friction, which is von Mises, for random increments.
void expect_von_mises(const std::string& library) {
  const auto model = make_constitutive(MaterialName{"umat"}, user_soil(library));
  Soil twin;
  twin.youngs_modulus = youngs;
  twin.poissons_ratio = poisson;
  twin.cohesion = strength;
  twin.friction_angle = 0.0;
  twin.cone = Soil::Cone::repose;
  const auto right = make_constitutive(MaterialName::drucker_prager, twin);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  // From zero stress along one direction, where both return algorithms are exact.
  for (int k = 0; k < 50; ++k) {
    Tensor strain, stress = Tensor::Zero(), expected = Tensor::Zero();
    for (int c = 0; c < 6; ++c) strain[c] = 2e-4 * any(random);
    std::vector<double> state(model->state_size());
    double plastic = 0.0, plastic_right = 0.0;
    for (int n = 0; n < 10; ++n) {
      plastic += model->advance(stress, strain, {}, state);
      plastic_right += right->advance(expected, strain);
    }
    EXPECT_LT((stress - expected).norm(), 1e-9 * expected.norm());
    EXPECT_NEAR(state[0], plastic_right, 1e-9 * plastic_right);
    EXPECT_NEAR(plastic, plastic_right, 1e-9 * plastic_right);
    // The strain that the library receives: engineering shear, 11 22 33 12 13 23.
    EXPECT_NEAR(state[1], 10.0 * strain[0], 1e-12);
    EXPECT_NEAR(state[1 + 4], 20.0 * strain[5], 1e-12);
    EXPECT_NEAR(state[1 + 5], 20.0 * strain[4], 1e-12);
  }
}

TEST(Umat, TheExampleInCppIsVonMises) { expect_von_mises(PORETWIN_UMAT_CPP); }

TEST(Umat, TheExampleInFortranIsVonMises) {
  if (std::string(PORETWIN_UMAT_FORTRAN).empty()) GTEST_SKIP() << "no gfortran: Debian package gfortran";
  expect_von_mises(PORETWIN_UMAT_FORTRAN);
}

TEST(Umat, FourAtATimeIsAsOneByOneAndAFailureSaysWhere) {
  const auto model = make_constitutive(MaterialName{"umat"}, user_soil(PORETWIN_UMAT_BROKEN));
  Four four{};
  std::vector<Quad> state(model->state_size());
  four.state = state.data();
  four.strain[1] = Lanes{1e-3, 2e-3, 0.02, 1e-3};
  try {
    model->advance(std::span(&four, 1));
    ADD_FAILURE() << "no failure";
  } catch (const MaterialFailure& failure) {
    EXPECT_EQ(failure.place, 2U);
    EXPECT_THAT(failure.what, HasSubstr("not finite after the strain increment 0 0.02 0"));
    EXPECT_THAT(failure.what, HasSubstr("and the state 0"));
  }
  EXPECT_DOUBLE_EQ(four.stress[1][1], 2e3);
}

/// The messages of the check of a case with this soil.
std::string complaint(const std::string& keys) {
  const auto path = std::filesystem::temp_directory_path() / "poretwin_umat.toml";
  std::ofstream(path) << "[case]\nend_time = 1\n[solid]\nmodel = \"umat\"\nparticle_spacing = 0.05\n[[soil]]\n"
                         "min = [0, 0]\nmax = [1, 1]\n"
                      << keys << "\n[[wall]]\npoints = [[0, 2], [0, 0], [1, 0], [1, 2]]\n";
  try {
    read_case(path);
  } catch (const CaseError& error) {
    return error.what();
  }
  return "";
}

TEST(Umat, TheCheckNamesWhatIsWrongWithALibrary) {
  const std::string library = std::string("library = \"") + PORETWIN_UMAT_CPP + "\"\n";
  const std::string sound = "properties = [1e7, 0.3, 5e3]\nstate_variables = 1\nyoungs_modulus = 1e7\n";
  EXPECT_EQ(complaint(library + sound), "");
  EXPECT_THAT(complaint(sound), HasSubstr("'soil[0].library': expected the shared library"));
  EXPECT_THAT(complaint("library = \"/nowhere/my_soil.so\"\n" + sound),
              HasSubstr("poretwin_umat.toml:9: key 'soil[0].library'"));
  EXPECT_THAT(complaint("library = \"/nowhere/my_soil.so\"\n" + sound), HasSubstr("/nowhere/my_soil.so: cannot open"));
  EXPECT_THAT(complaint(std::string("library = \"") + PORETWIN_UMAT_EMPTY + "\"\n" + sound),
              HasSubstr("has no function umat_"));
  EXPECT_THAT(complaint(library + "properties = [1e7, 0.5, 5e3]\nstate_variables = 1\n"), HasSubstr("not finite"));
  EXPECT_THAT(complaint(library + "properties = [1e7, 0.3, 5e3]\nstate_variables = 1\nyoungs_modulus = 9e6\n"),
              HasSubstr("'soil[0].youngs_modulus': with poissons_ratio the stiffness"));
}

}  // namespace
}  // namespace poretwin::solid
