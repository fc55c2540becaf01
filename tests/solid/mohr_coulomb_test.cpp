// The return to Coulomb's surface, compared with tabulated exact returns and with a search over all sets of active
// faces.
#include "solid_solver/material/model.hpp"
#include "tests/instructions.hpp"
#include "tests/solid/reference/table.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <random>

namespace poretwin::solid {
namespace {

using test::Table;

Soil soil_of(double youngs, double poisson, double phi, double psi, double cohesion) {
  Soil soil;
  soil.youngs_modulus = youngs;
  soil.poissons_ratio = poisson;
  soil.friction_angle = phi;
  soil.dilation_angle = psi;
  soil.cohesion = cohesion;
  return soil;
}

std::unique_ptr<ConstitutiveModel> mohr_coulomb(const Soil& soil) {
  return make_constitutive(MaterialName::mohr_coulomb, soil);
}

Eigen::Matrix3d matrix3(const Tensor& t) { return matrix_of<3>(t); }

Tensor tensor_of(const Eigen::Matrix3d& m) {
  Tensor t;
  t << m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(1, 2), m(0, 2);
  return t;
}

/// Principal stresses, the largest first.
std::array<double, 3> principal(const Tensor& t) {
  const Eigen::Vector3d values = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix3(t)).eigenvalues();
  return {values[2], values[1], values[0]};
}

TEST(MohrCoulomb, ReturnsToFacesEdgesAndApexAsTabulated) {
  const Table table = Table::read("mohr_coulomb_return.csv");
  ASSERT_EQ(table.size(), 200U);
  double worst = 0.0;
  for (std::size_t row = 0; row < table.size(); ++row) {
    const auto at = [&](const std::string& name) { return table.number(row, name); };
    const auto tensor = [&](const std::string& name) {
      Tensor t;
      t << at(name + "_xx"), at(name + "_yy"), at(name + "_zz"), at(name + "_xy"), at(name + "_yz"), at(name + "_xz");
      return t;
    };
    const auto model = mohr_coulomb(soil_of(at("E"), at("nu"), at("phi_deg"), at("psi_deg"), at("c")));
    Tensor stress = tensor("s0");
    const Tensor right = tensor("s");
    const double size = std::max(matrix3(stress).norm(), matrix3(right).norm());  // the apex may be at zero
    const double plastic = model->advance(stress, tensor("de"));
    EXPECT_EQ(plastic > 0.0, at("sum_multipliers") > 0.0) << "row " << row;
    const double off = (matrix3(stress) - matrix3(right)).norm() / size;
    EXPECT_LT(off, 1e-8) << "row " << row << ", " << table.word(row, "region");
    worst = std::max(worst, off);
  }
  RecordProperty("worst", fmt::format("{:.2g}", worst));
}

/// The exact return by trying all sets of active planes: those of the surface, with c, phi and psi, and the tension
/// cut-off. Exactly one set gives non-negative multipliers and an admissible stress.
Tensor return_by_search(const Tensor& trial, const Soil& soil, double limit) {
  const double sin_phi = std::sin(soil.friction_angle * std::numbers::pi / 180.0),
               cos_phi = std::cos(soil.friction_angle * std::numbers::pi / 180.0),
               sin_psi = std::sin(soil.dilation_angle * std::numbers::pi / 180.0);
  const Elasticity elasticity = Elasticity::of(soil);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(matrix3(trial));
  const Eigen::Vector3d t = axes.eigenvalues();
  const Eigen::Matrix3d stiffness = (elasticity.bulk - 2.0 / 3.0 * elasticity.shear) * Eigen::Matrix3d::Ones() +
                                    2.0 * elasticity.shear * Eigen::Matrix3d::Identity();
  std::vector<Eigen::Vector3d> normals, flows;
  std::vector<double> offsets;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      if (a == b) continue;
      normals.emplace_back((1.0 + sin_phi) * Eigen::Vector3d::Unit(a) - (1.0 - sin_phi) * Eigen::Vector3d::Unit(b));
      flows.emplace_back((1.0 + sin_psi) * Eigen::Vector3d::Unit(a) - (1.0 - sin_psi) * Eigen::Vector3d::Unit(b));
      offsets.push_back(2.0 * soil.cohesion * cos_phi);
    }
  for (int a = 0; a < 3; ++a) {
    normals.emplace_back(Eigen::Vector3d::Unit(a));
    flows.emplace_back(Eigen::Vector3d::Unit(a));
    offsets.push_back(limit);
  }
  const double tolerance = 1e-9 * (1.0 + t.norm());
  for (int size = 0; size <= 3; ++size)
    for (unsigned set = 0; set < 1U << normals.size(); ++set) {
      if (std::popcount(set) != size) continue;
      std::vector<std::size_t> active;
      for (std::size_t k = 0; k < normals.size(); ++k)
        if (set >> k & 1U) active.push_back(k);
      Eigen::MatrixXd system(size, size);
      Eigen::VectorXd excess(size);
      for (int i = 0; i < size; ++i) {
        const auto k = active[static_cast<std::size_t>(i)];
        excess[i] = normals[k].dot(t) - offsets[k];
        for (int j = 0; j < size; ++j)
          system(i, j) = normals[k].dot(stiffness * flows[active[static_cast<std::size_t>(j)]]);
      }
      Eigen::VectorXd multipliers(size);
      if (size > 0) {
        const Eigen::FullPivLU<Eigen::MatrixXd> lu(system);
        if (!lu.isInvertible()) continue;
        multipliers = lu.solve(excess);
        if (multipliers.minCoeff() < -1e-15) continue;
      }
      Eigen::Vector3d s = t;
      for (int i = 0; i < size; ++i) s -= multipliers[i] * stiffness * flows[active[static_cast<std::size_t>(i)]];
      bool inside = true;
      for (std::size_t k = 0; k < normals.size(); ++k) inside = inside && normals[k].dot(s) - offsets[k] < tolerance;
      if (inside) return tensor_of(axes.eigenvectors() * s.asDiagonal() * axes.eigenvectors().transpose());
    }
  ADD_FAILURE() << "no set of active planes";
  return trial;
}

TEST(MohrCoulomb, IsTheOneReturnThatASearchOverAllPlanesFinds) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  double worst = 0.0;
  int cut_off = 0, sheared = 0;
  for (int k = 0; k < 3000; ++k) {
    Soil soil = soil_of(1e7, 0.25 + 0.2 * any(random), 35.0 * std::abs(any(random)), 0.0, 1e4 * std::abs(any(random)));
    // Dilation of zero, part of the friction angle, or all of it; beyond the apex without dilation the tension cut-off
    // acts.
    soil.dilation_angle = soil.friction_angle * std::max(0.0, any(random));
    const double apex = soil.cohesion / std::tan(soil.friction_angle * std::numbers::pi / 180.0);
    double limit = apex;
    if (k % 2 == 0) {
      soil.tensile_strength = apex * std::abs(any(random));
      limit = *soil.tensile_strength;
    }
    Tensor stress;
    for (int c = 0; c < 6; ++c) stress[c] = 2e4 * any(random);
    if (k % 3 == 0) stress[4] = stress[5] = 0.0;
    stress[0] += 2e4 * any(random);
    const Tensor right = return_by_search(stress, soil, limit);
    Tensor found = stress;
    const double plastic = mohr_coulomb(soil)->advance(found, Tensor::Zero());
    const double off = (matrix3(found) - matrix3(right)).norm() / matrix3(stress).norm();
    EXPECT_LT(off, 1e-8) << "trial " << k;
    worst = std::max(worst, off);
    cut_off += principal(found)[0] > limit - 1e-6 ? 1 : 0;
    sheared += plastic > 0.0 ? 1 : 0;
  }
  RecordProperty("worst", fmt::format("{:.2g}", worst));
  EXPECT_GT(cut_off, 300);
  EXPECT_GT(sheared, 1500);
}

TEST(MohrCoulomb, WithoutDilationThereIsAnApexToo) {
  const Soil soil = soil_of(1e7, 0.3, 30.0, 0.0, 1e3);
  Tensor stress = Tensor::Zero();
  const Tensor apart = (Tensor() << 1e-2, 1e-2, 1e-2, 0.0, 0.0, 0.0).finished();
  EXPECT_GT(mohr_coulomb(soil)->advance(stress, apart), 0.0);
  for (int d = 0; d < 3; ++d) EXPECT_NEAR(stress[d], 1e3 * std::sqrt(3.0), 1e-6);
}

TEST(MohrCoulomb, SoilWithoutStressStaysWithoutIt) {
  Tensor stress = Tensor::Zero();
  EXPECT_EQ(mohr_coulomb(soil_of(1e7, 0.3, 30.0, 0.0, 1e3))->advance(stress, Tensor::Zero()), 0.0);
  EXPECT_EQ(stress.norm(), 0.0);
  mohr_coulomb(soil_of(1e7, 0.3, 30.0, 10.0, 0.0))->advance(stress, Tensor::Constant(1e-3));
  EXPECT_TRUE(stress.allFinite());
}

TEST(MohrCoulomb, FourAtATimeIsAsOneByOne) {
  Soil wet = soil_of(1e7, 0.3, 30.0, 10.0, 500.0), cut = soil_of(1e7, 0.3, 30.0, 0.0, 1000.0),
       grains = soil_of(1e7, 0.3, 35.0, 0.0, 0.0), clay = soil_of(1e7, 0.45, 0.0, 0.0, 2000.0);
  wet.saturated_cohesion = 20.0;
  wet.initial_saturation = 0.2;
  wet.maximum_void_ratio = 0.8;
  cut.tensile_strength = 200.0;
  clay.tensile_strength = 0.0;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  std::size_t yielded = 0, n = 0;
  test::with_each_instruction_set([&] {
    for (const Soil& soil : {wet, cut, grains, clay}) {
      const auto model = mohr_coulomb(soil);
      for (int k = 0; k < 400; ++k) {
        Four four;
        std::array<Tensor, n_lanes> stress;
        std::array<double, n_lanes> plastic;
        const bool plane = k % 2 == 0;
        for (std::size_t l = 0; l < n_lanes; ++l) {
          const double mean = -1e4 * std::abs(any(random)), size = std::pow(10.0, -3.5 + 1.5 * any(random));
          Tensor strain;
          stress[l] = Tensor::Zero();
          for (int c = 0; c < 6; ++c) {
            stress[l][c] = (c < 3 ? mean : 0.0) + (plane && c > 3 ? 0.0 : 0.2 * mean * any(random));
            strain[c] = plane && c > 3 ? 0.0 : size * any(random);
          }
          const Condition condition{0.5 + 0.5 * any(random), 0.8 + 0.1 * any(random)};
          for (int c = 0; c < 6; ++c) {
            four.stress[c][l] = stress[l][c];
            four.strain[c][l] = strain[c];
          }
          four.saturation[l] = condition.saturation;
          four.void_ratio[l] = condition.void_ratio;
          plastic[l] = model->advance(stress[l], strain, condition, {});
          yielded += plastic[l] > 0.0 ? 1 : 0;
        }
        model->advance(std::span(&four, 1));
        for (std::size_t l = 0; l < n_lanes; ++l, ++n) {
          EXPECT_NEAR(four.plastic[l], plastic[l], 1e-9 * plastic[l] + 1e-15);
          for (int c = 0; c < 6; ++c) EXPECT_NEAR(four.stress[c][l], stress[l][c], 1e-9 * (1e3 + stress[l].norm()));
        }
      }
    }
  });
  EXPECT_GT(yielded, n / 4);
  EXPECT_LT(yielded, n * 9 / 10);
}

}  // namespace
}  // namespace poretwin::solid
