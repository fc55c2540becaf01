// Element tests: single material points on strain paths whose stresses have a closed form. Every integration of the
// Drucker-Prager model is tested on the same paths, with step sizes that differ by a factor of a hundred.
#include "common/core/error.hpp"
#include "solid_solver/material/cone.hpp"
#include "solid_solver/material/model.hpp"
#include "tests/instructions.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>

namespace poretwin::solid {
namespace {

using Model = SolidCase::Model;

constexpr double bound = 1e-3;  // relative error of the stress, along the whole path and for every step size
constexpr double bulk = 2.5e6, shear = 3e6 / 2.6, youngs = 3e6;
constexpr double root3 = std::numbers::sqrt3;

Soil sand(double cohesion = 0.0, double dilation = 0.0, Soil::Cone cone = Soil::Cone::paper) {
  Soil soil;
  soil.youngs_modulus = youngs;
  soil.poissons_ratio = 0.3;
  soil.cohesion = cohesion;
  soil.friction_angle = 30.0;
  soil.dilation_angle = dilation;
  soil.cone = cone;
  return soil;
}

Cone cone_of(const Soil& soil) { return fit_cone(soil.cohesion, soil.friction_angle, soil.dilation_angle, soil.cone); }

Tensor tensor(double xx, double yy, double zz, double xy = 0.0) {
  Tensor t = Tensor::Zero();
  t << xx, yy, zz, xy, 0.0, 0.0;
  return t;
}

/// An integration and its size of strain steps.
struct Setting {
  Model model;
  double step;
};

class Element : public testing::TestWithParam<Setting> {
 protected:
  [[nodiscard]] std::unique_ptr<ConstitutiveModel> model(const Soil& soil) const {
    return make_constitutive(GetParam().model, soil);
  }
  /// Applies a strain in steps, without checks.
  double strain_by(const ConstitutiveModel& soil, Tensor& stress, const Tensor& total,
                   const Condition& condition = {}) const {
    const int steps = static_cast<int>(std::lround(total.cwiseAbs().maxCoeff() / GetParam().step));
    double plastic = 0.0;
    for (int k = 0; k < steps; ++k) plastic += soil.advance(stress, total / steps, condition);
    return plastic;
  }
  /// Strains along a direction whose largest component is 1, up to `size`; compares every state with exact(strain), and
  /// with the cone.
  void follow(const ConstitutiveModel& soil, const Cone& cone, Tensor& stress, const Tensor& direction, double size,
              const std::function<Tensor(double)>& exact) const {
    const int steps = static_cast<int>(std::lround(size / GetParam().step));
    const double scale = stress.norm();
    double worst = 0.0, outside = 0.0;
    for (int k = 1; k <= steps; ++k) {
      soil.advance(stress, size / steps * direction);
      const Tensor right = exact(size * k / steps);
      worst = std::max(worst, (stress - right).norm() / std::max(right.norm(), 1e-3 * scale));
      outside = std::max(outside, yield_function(stress, cone));
    }
    EXPECT_LT(worst, bound);
    EXPECT_LT(outside, 1e-9 * std::max(scale, cone.k));
    RecordProperty("worst", std::to_string(worst));
  }
};

INSTANTIATE_TEST_SUITE_P(Drucker, Element,
                         testing::Values(Setting{Model::drucker_prager, 1e-4}, Setting{Model::drucker_prager, 1e-5},
                                         Setting{Model::drucker_prager, 1e-6},
                                         Setting{Model::drucker_prager_rate, 1e-6},
                                         Setting{Model::drucker_prager_rate, 2e-7}),
                         [](const auto& instance) {
                           const auto& s = instance.param;
                           return std::string(s.model == Model::drucker_prager ? "ReturnMap" : "Rate") + "Step" +
                                  std::to_string(std::lround(1e7 * s.step));
                         });

TEST_P(Element, SimpleShearFromIsotropicStress) {
  const Soil soil = sand(200.0);
  const Cone cone = cone_of(soil);
  Tensor stress = tensor(-1e4, -1e4, -1e4);
  const double strength = cone.k + 3e4 * cone.alpha;
  follow(*model(soil), cone, stress, tensor(0.0, 0.0, 0.0, 1.0), 1e-2,
         [&](double e) { return tensor(-1e4, -1e4, -1e4, std::min(2.0 * shear * e, strength)); });
}

// From the stresses at rest the deviator turns towards the shear: with psi = 0 its angle theta to the strain satisfies
// d theta / d e = -2 G sin(theta) / R, at the constant radius R.
TEST_P(Element, SimpleShearFromK0Stress) {
  const Soil soil = sand(50.0);
  const Cone cone = cone_of(soil);
  const Tensor rest = tensor(-4e3, -7e3, -4e3);
  Tensor stress = rest;
  const double radius = cone.k - cone.alpha * trace(rest), across = root_j2(rest);
  const double first = std::sqrt(radius * radius - across * across) / (2.0 * shear);  // strain at first yield
  const double start = std::atan2(across, 2.0 * shear * first);
  follow(*model(soil), cone, stress, tensor(0.0, 0.0, 0.0, 1.0), 2e-2, [&](double e) {
    double along = 2.0 * shear * e, left = 1.0;
    if (e > first) {
      const double angle = 2.0 * std::atan(std::tan(0.5 * start) * std::exp(-2.0 * shear * (e - first) / radius));
      along = radius * std::cos(angle);
      left = radius * std::sin(angle) / across;
    }
    Tensor right = left * deviator(rest);
    for (int d = 0; d < 3; ++d) right[d] += trace(rest) / 3.0;
    right[3] = along;
    return right;
  });
}

// Dilation against fixed boundaries raises the pressure: d I1 = -9 K alpha_psi d lambda.
TEST_P(Element, ConfinedDilationRaisesThePressure) {
  const Soil soil = sand(0.0, 10.0);
  const Cone cone = cone_of(soil);
  Tensor stress = tensor(-1e4, -1e4, -1e4);
  const double first = 3e4 * cone.alpha / (2.0 * shear);
  follow(*model(soil), cone, stress, tensor(0.0, 0.0, 0.0, 1.0), 1e-2, [&](double e) {
    const double multiplier =
        2.0 * shear * std::max(0.0, e - first) / (9.0 * bulk * cone.alpha * cone.alpha_psi + shear);
    const double mean = -1e4 - 3.0 * bulk * cone.alpha_psi * multiplier;
    return tensor(mean, mean, mean, e < first ? 2.0 * shear * e : cone.k - 3.0 * cone.alpha * mean);
  });
}

TEST_P(Element, OneDimensionalExtensionFromRest) {
  // Towards active failure the deviator shrinks, changes sign and ends on the cone; its direction is unchanged.
  const Soil soil = sand(100.0, 10.0);
  const Cone cone = cone_of(soil);
  const Tensor rest = tensor(-4e4, -8e4, -4e4);
  Tensor stress = rest;
  const double d_mean = bulk, d_deviator = 2.0 * shear / root3;  // p and the signed sqrt(J2), per strain
  const double p0 = trace(rest) / 3.0, q0 = -root_j2(rest);
  const double first = (cone.k - 3.0 * cone.alpha * p0 - q0) / (d_deviator + 3.0 * cone.alpha * d_mean);
  follow(*model(soil), cone, stress, tensor(0.0, 1.0, 0.0), 2.1e-2, [&](double e) {
    const double beyond = std::max(0.0, e - first);
    const double multiplier =
        (d_deviator + 3.0 * cone.alpha * d_mean) * beyond / (9.0 * bulk * cone.alpha * cone.alpha_psi + shear);
    const double p = p0 + d_mean * e - 3.0 * bulk * cone.alpha_psi * multiplier;
    const double q = q0 + d_deviator * e - shear * multiplier;
    return tensor(p - q / root3, p + 2.0 * q / root3, p - q / root3);
  });
}

// Triaxial compression at constant cell pressure: the lateral strain of every step is found so that the cell pressure
// is kept. The strength is Coulomb's on the `outer` cone, and the sample dilates by the flow rule.
TEST_P(Element, TriaxialCompressionAndUnloading) {
  const Soil soil = sand(300.0, 10.0, Soil::Cone::outer);
  const Cone cone = cone_of(soil);
  const auto sample = model(soil);
  constexpr double cell = 1e4, phi = std::numbers::pi / 6.0;
  const double strength = (2.0 * 300.0 * std::cos(phi) + 2.0 * cell * std::sin(phi)) / (1.0 - std::sin(phi));
  Tensor stress = tensor(-cell, -cell, -cell);
  double axial = 0.0, lateral = 0.0, worst = 0.0;
  auto load = [&](double strain) {  // secant search: the response is piecewise smooth
    auto attempt = [&](double side) {
      Tensor next = stress;
      sample->advance(next, tensor(side, side, strain));
      return next;
    };
    double a = -0.3 * strain, b = -0.6 * strain;
    for (int k = 0; k < 60 && std::abs(b - a) > 1e-15; ++k) {
      const double fa = attempt(a)[0] + cell, fb = attempt(b)[0] + cell;
      const double next = fa == fb ? b : b - fb * (b - a) / (fb - fa);
      a = b;
      b = next;
    }
    stress = attempt(b);
    axial += strain;
    lateral += b;
  };
  const int steps = static_cast<int>(std::lround(2e-2 / GetParam().step));
  double volumetric_at_yield = 0.0, axial_at_yield = 0.0;
  for (int k = 0; k < steps; ++k) {
    load(-2e-2 / steps);
    const double deviator_stress = std::min(-youngs * axial, strength);
    worst = std::max(worst, std::abs(-stress[2] - cell - deviator_stress) / (cell + deviator_stress));
    worst = std::max(worst, std::abs(stress[0] + cell) / cell);
    if (-youngs * axial > 1.5 * strength && axial_at_yield == 0.0) {
      axial_at_yield = axial;
      volumetric_at_yield = axial + 2.0 * lateral;
    }
    EXPECT_LT(yield_function(stress, cone), 1e-5);
  }
  EXPECT_LT(worst, bound);
  const double rate = (axial + 2.0 * lateral - volumetric_at_yield) / (axial - axial_at_yield);
  const double flow = 3.0 * cone.alpha_psi / (cone.alpha_psi - 1.0 / root3);
  EXPECT_NEAR(rate, flow, bound * std::abs(flow));
  const double before = stress[2];
  for (int k = 0; k < 10; ++k) load(1e-5);
  EXPECT_NEAR(stress[2] - before, youngs * 1e-4, bound * youngs * 1e-4);
  EXPECT_NEAR(stress[0], -cell, bound * cell);
}

TEST_P(Element, UnloadingIsElastic) {
  const auto soil = model(sand(200.0));
  Tensor stress = tensor(-1e4, -1e4, -1e4);
  strain_by(*soil, stress, tensor(0.0, 0.0, 0.0, 2e-2));
  const Tensor before = stress, back = tensor(0.0, 0.0, 0.0, -1e-4);
  EXPECT_EQ(soil->advance(stress, back), 0.0);
  Tensor expected = before;
  soil->initial_moduli().add_stress(back.data(), expected.data());
  EXPECT_NEAR((stress - expected).norm(), 0.0, 1e-9);
}

TEST_P(Element, PlasticStrainIsWhatIsNotElastic) {
  const auto soil = model(sand(200.0));
  const Cone cone = cone_of(sand(200.0));
  Tensor stress = tensor(-1e4, -1e4, -1e4);
  const double plastic = strain_by(*soil, stress, tensor(0.0, 0.0, 0.0, 1e-2));
  const double right = 2.0 * (1e-2 - (cone.k + 3e4 * cone.alpha) / (2.0 * shear)) / root3;
  EXPECT_NEAR(plastic, right, bound * right);
}

TEST_P(Element, TensionEndsAtTheApex) {
  const Soil cohesive = sand(100.0);
  const Cone cone = cone_of(cohesive);
  const double apex = cone.k / cone.alpha / 3.0;
  Tensor stress = tensor(-1e3, -1e3, -1e3);
  follow(*model(cohesive), cone, stress, tensor(1.0, 1.0, 1.0), 5e-3, [&](double e) {
    const double mean = std::min(-1e3 + 3.0 * bulk * e, apex);
    return tensor(mean, mean, mean);
  });
  Tensor loose = tensor(-100.0, -120.0, -100.0, 10.0);
  EXPECT_GT(model(sand())->advance(loose, tensor(1e-2, 1e-2, 0.0, 1e-3)), 0.0);
  EXPECT_NEAR(loose.norm(), 0.0, 1e-9);
}

TEST_P(Element, TensionCutOffLeavesTheShearThatTheConeBears) {
  Soil soil = sand(1000.0);
  soil.tensile_strength = 100.0;
  const Cone cone = cone_of(soil);
  const auto cut = model(soil);
  Tensor stress = tensor(-1e3, -1e3, -1e3, 50.0);
  strain_by(*cut, stress, tensor(1e-3, 1e-3, 1e-3));
  EXPECT_NEAR((stress - tensor(100.0, 100.0, 100.0, 50.0)).norm(), 0.0, 1e-6);
  strain_by(*cut, stress, tensor(1e-3, 1e-3, 1e-3, 1e-2));
  const double edge = cone.k - 300.0 * cone.alpha;
  EXPECT_NEAR(trace(stress), 300.0, 1e-6);
  EXPECT_LE(stress[3], edge + 1e-6);
  // The rate form reduces the shear stress for a volume strain that the cut-off also accounts for: it ends inside.
  if (GetParam().model == Model::drucker_prager) {
    EXPECT_NEAR(stress[3], edge, 1e-6);
  }
}

TEST_P(Element, WettingTakesTheStrengthItTakes) {
  Soil soil = sand(550.0);
  soil.initial_saturation = 0.2;
  soil.saturated_cohesion = 10.0;
  const auto wetted = model(soil);
  Tensor stress = tensor(-1e3, -1e3, -1e3);
  strain_by(*wetted, stress, tensor(0.0, 0.0, 0.0, 1e-2), {0.2, 0.7});
  const double dry = stress[3];
  for (const double saturation : {0.6, 1.0}) {
    wetted->advance(stress, Tensor::Zero(), {saturation, 0.7});
    Cone cone = fit_cone(cohesion_at(soil, saturation), 30.0, 0.0);
    EXPECT_NEAR(stress[3], cone.k + 3e3 * cone.alpha, 1e-6);
    EXPECT_NEAR(trace(stress), -3e3, 1e-6);
  }
  EXPECT_LT(stress[3], dry - 300.0);
}

TEST_P(Element, DilationEndsAtTheLargestVoidRatio) {
  Soil soil = sand(0.0, 10.0, Soil::Cone::plane_strain);
  soil.maximum_void_ratio = 0.8;
  const auto loosening = model(soil);
  Tensor stress = tensor(-1e4, -1e4, -1e4);
  strain_by(*loosening, stress, tensor(0.0, 0.0, 0.0, 1e-2), {0.0, 0.79});
  const double risen = trace(stress);
  EXPECT_LT(risen, -3.1e4);
  strain_by(*loosening, stress, tensor(0.0, 0.0, 0.0, 1e-2), {0.0, 0.81});
  EXPECT_NEAR(trace(stress), risen, 1e-6 * std::abs(risen));
  EXPECT_NEAR(stress[3], -std::sin(std::numbers::pi / 6.0) * risen / 3.0, 1e-3 * std::abs(risen));
}

TEST_P(Element, FourAtATimeIsAsOneByOne) {
  Soil wet = sand(500.0, 10.0, Soil::Cone::plane_strain), cut = sand(1000.0), grains = sand();
  wet.saturated_cohesion = 20.0;
  wet.initial_saturation = 0.2;
  wet.maximum_void_ratio = 0.8;
  cut.tensile_strength = 200.0;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  std::size_t yielded = 0, turned = 0, n = 0;
  test::with_each_instruction_set([&] {
    for (const Soil& soil : {wet, cut, grains}) {
      const auto sample = model(soil);
      for (int k = 0; k < 500; ++k) {
        Four four;
        std::array<Tensor, n_lanes> stress, strain;
        std::array<double, n_lanes> plastic;
        for (std::size_t l = 0; l < n_lanes; ++l) {
          // From inside the cone in every direction, with steps from nearly zero to far beyond the cone.
          const double mean = -1e4 * std::abs(any(random)), size = std::pow(10.0, -3.5 + 1.5 * any(random));
          stress[l] = tensor(mean, mean, mean);
          for (int c = 0; c < 6; ++c) {
            stress[l][c] += 0.2 * mean * any(random);
            strain[l][c] = size * any(random);
          }
          const Condition condition{0.5 + 0.5 * any(random), 0.8 + 0.1 * any(random)};
          for (int c = 0; c < 6; ++c) {
            four.stress[c][l] = stress[l][c];
            four.strain[c][l] = strain[l][c];
          }
          four.saturation[l] = condition.saturation;
          four.void_ratio[l] = condition.void_ratio;
          const Tensor before = deviator(stress[l]);
          plastic[l] = sample->advance(stress[l], strain[l], condition);
          yielded += plastic[l] > 0.0 ? 1 : 0;
          const Tensor after = deviator(stress[l]);
          turned += contract(before, after) < 0.9 * 2.0 * root_j2(before) * root_j2(after) ? 1 : 0;
        }
        sample->advance(std::span(&four, 1));
        for (std::size_t l = 0; l < n_lanes; ++l, ++n) {
          EXPECT_NEAR(four.plastic[l], plastic[l], 1e-12 * plastic[l]);
          for (int c = 0; c < 6; ++c) EXPECT_NEAR(four.stress[c][l], stress[l][c], 1e-12 * (1e3 + stress[l].norm()));
        }
      }
    }
  });
  EXPECT_GT(yielded, n / 4);
  EXPECT_LT(yielded, n * 3 / 4);
  EXPECT_GT(turned, n / 20);
}

}  // namespace
}  // namespace poretwin::solid
