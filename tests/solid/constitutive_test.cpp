// Elastic moduli, constants of the cone, Jaumann rate. Stress paths are in element_test.cpp.
#include "solid_solver/material/cone.hpp"
#include "solid_solver/material/elastic.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace poretwin::solid {
namespace {

Soil sand(double cohesion = 0.0, double dilation = 0.0) {
  Soil soil;
  soil.youngs_modulus = 3e6;
  soil.poissons_ratio = 0.3;
  soil.cohesion = cohesion;
  soil.friction_angle = 30.0;
  soil.dilation_angle = dilation;
  return soil;
}

Tensor tensor(double xx, double yy, double zz, double xy = 0.0) {
  Tensor t = Tensor::Zero();
  t << xx, yy, zz, xy, 0.0, 0.0;
  return t;
}

TEST(Elastic, UniaxialStrainGivesTheConstrainedModulus) {
  const LinearElastic model(sand());
  Tensor stress = Tensor::Zero();
  EXPECT_EQ(model.advance(stress, tensor(0.0, -1e-3, 0.0)), 0.0);
  const double m = 3e6 * 0.7 / (1.3 * 0.4);
  EXPECT_NEAR(stress[1], -1e-3 * m, 1e-9 * m);
  EXPECT_NEAR(stress[0], -1e-3 * m * 0.3 / 0.7, 1e-9 * m);
  EXPECT_NEAR(stress[2], stress[0], 1e-12 * m);
  EXPECT_NEAR(model.initial_moduli().constrained(), m, 1e-9 * m);
}

TEST(Cone, MatchesTheClosedForms) {
  const Cone cone = fit_cone(1000.0, 30.0, 0.0);
  const double t = std::tan(std::numbers::pi / 6.0);
  EXPECT_NEAR(cone.alpha, t / std::sqrt(9.0 + 12.0 * t * t), 1e-15);
  EXPECT_NEAR(cone.k, 3000.0 / std::sqrt(9.0 + 12.0 * t * t), 1e-9);
  EXPECT_EQ(cone.alpha_psi, 0.0);
  // With psi = phi the plane-strain fit equals the paper's; with psi = 0 it is 3 alpha = sin(phi).
  const Cone paper = fit_cone(500.0, 25.0, 25.0), strain = fit_cone(500.0, 25.0, 25.0, Soil::Cone::plane_strain);
  EXPECT_NEAR(strain.alpha, paper.alpha, 1e-12);
  EXPECT_NEAR(strain.k, paper.k, 1e-9);
  EXPECT_NEAR(fit_cone(0.0, 30.0, 0.0, Soil::Cone::plane_strain).alpha, 0.5 / 3.0, 1e-12);
  EXPECT_NEAR(fit_cone(0.0, 30.0, 0.0, Soil::Cone::repose).alpha, t / 3.0, 1e-15);
}

TEST(Cone, EveryFitMeetsCoulombWhereItPromisesTo) {
  constexpr double c = 300.0, phi = 28.0, radians = phi * std::numbers::pi / 180.0;
  const double s = std::sin(radians);
  // 3D: lowest and highest principal stress at failure satisfy s1 (1 - sin) - s3 (1 + sin) = -2 c cos.
  auto coulomb = [&](double high, double low) { return (high - low) + (high + low) * s - 2.0 * c * std::cos(radians); };
  auto at_failure = [&](const Cone& cone, const Tensor& direction) {  // p = 10 kPa, deviator scaled onto the cone
    Tensor stress = (cone.k + 3e4 * cone.alpha) / root_j2(direction) * direction;
    for (int d = 0; d < 3; ++d) stress[d] -= 1e4;
    return stress;
  };
  const Tensor compression = at_failure(fit_cone(c, phi, 0.0, Soil::Cone::outer), tensor(1.0, 1.0, -2.0));
  EXPECT_NEAR(coulomb(compression[0], compression[2]), 0.0, 1e-8);
  const Tensor extension = at_failure(fit_cone(c, phi, 0.0, Soil::Cone::inner), tensor(-1.0, -1.0, 2.0));
  EXPECT_NEAR(coulomb(extension[2], extension[0]), 0.0, 1e-8);
  // Plane strain: at failure the plastic strain in z vanishes, s_zz = -2 alpha_psi sqrt(J2).
  for (const double psi : {0.0, 10.0, 28.0}) {
    const Cone cone = fit_cone(c, phi, psi, Soil::Cone::plane_strain);
    const double a = cone.alpha_psi, in_plane = std::sqrt(1.0 - 3.0 * a * a);
    const Tensor stress = at_failure(cone, tensor(in_plane + a, -in_plane + a, -2.0 * a));
    EXPECT_NEAR(coulomb(stress[0], stress[1]), 0.0, 1e-8) << psi;
    EXPECT_NEAR(3.0 * a / in_plane, std::sin(psi * std::numbers::pi / 180.0), 1e-12);
  }
  // Eq. (32) with psi = 0 mobilises 26 degrees for a nominal 31; the angle of repose is mobilised fully.
  auto mobilised = [](Soil::Cone fit) {
    return std::atan(3.0 * fit_cone(0.0, 31.0, 0.0, fit).alpha) * 180.0 / std::numbers::pi;
  };
  EXPECT_NEAR(mobilised(Soil::Cone::paper), 26.3, 0.1);
  EXPECT_NEAR(mobilised(Soil::Cone::repose), 31.0, 1e-12);
}

TEST(Cone, CohesionFallsWithSaturation) {
  Soil soil = sand(550.0);
  EXPECT_EQ(cohesion_at(soil, 1.0), 550.0);  // without a saturated cohesion, Eq. (36) is off
  soil.initial_saturation = 0.2;
  soil.saturated_cohesion = 10.0;
  EXPECT_DOUBLE_EQ(cohesion_at(soil, 0.2), 550.0);  // as printed, c(s_r0) would be 442 Pa
  EXPECT_DOUBLE_EQ(cohesion_at(soil, 0.6), 280.0);
  EXPECT_DOUBLE_EQ(cohesion_at(soil, 1.0), 10.0);
  EXPECT_DOUBLE_EQ(cohesion_at(soil, 0.0), 550.0);
}

TEST(Cone, ReductionDividesCohesionAndTangent) {
  const Soil weak = weakened(sand(700.0, 29.0), 1.4);
  EXPECT_NEAR(weak.cohesion, 500.0, 1e-9);
  EXPECT_NEAR(std::tan(weak.friction_angle * std::numbers::pi / 180.0), std::tan(std::numbers::pi / 6.0) / 1.4, 1e-12);
  EXPECT_LE(weak.dilation_angle, weak.friction_angle);
}

TEST(Cone, ReductionDividesWhatAMaterialDeclaresAsAStrength) {
  Soil soil = sand();
  soil.own_numbers = {{"peak", 600.0}, {"softening", 3.0}};
  const Soil weak = weakened(soil, 1.5, {{"peak", 0.0, {}, {}, true}, {"softening", 0.0, {}, {}, false}});
  EXPECT_NEAR(weak.own("peak"), 400.0, 1e-9);
  EXPECT_EQ(weak.own("softening"), 3.0);
}

TEST(Jaumann, TurnsAStressWithItsMaterial) {
  // Turning by 90 degrees in many small steps exchanges xx and yy.
  Tensor stress = tensor(-100.0, -300.0, -50.0);
  const double angle = std::numbers::pi / 2.0;
  constexpr int steps = 20000;
  const Mat<2> gradient{{0.0, -1.0}, {1.0, 0.0}};
  Tensor rate;
  for (int k = 0; k < steps; ++k) {
    spin_rate<2>(stress.data(), gradient.data(), rate.data());
    stress += angle / steps * rate;
  }
  EXPECT_NEAR(stress[0], -300.0, 0.1);
  EXPECT_NEAR(stress[1], -100.0, 0.1);
  EXPECT_NEAR(stress[3], 0.0, 0.1);
  EXPECT_EQ(stress[2], -50.0);
  Mat<3> turn = Mat<3>::Zero();
  turn.block<2, 2>(0, 0) = gradient;
  Tensor same = tensor(-100.0, -300.0, -50.0, 7.0);
  Tensor two, three;
  spin_rate<2>(same.data(), gradient.data(), two.data());
  spin_rate<3>(same.data(), turn.data(), three.data());
  EXPECT_LT((two - three).norm(), 1e-12);
}

}  // namespace
}  // namespace poretwin::solid
