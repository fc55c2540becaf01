// The mu(I) rheology on single points, compared with closed forms and with a plain integration of its equations.
#include "solid_solver/material/element.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace poretwin::solid {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Glass beads of 1 mm.
Soil beads(double solid_fraction = 0.6, double dilatancy = 0.0) {
  Soil soil;
  soil.youngs_modulus = 1e6;
  soil.poissons_ratio = 0.3;
  soil.grain_density = 2500.0;
  soil.porosity = 1.0 - solid_fraction;
  soil.own_numbers = {{"grain_diameter", 1e-3},           {"static_friction", 0.38},        {"limiting_friction", 0.64},
                      {"inertial_number", 0.279},         {"viscous_number", 0.005},        {"dilatancy", dilatancy},
                      {"critical_solid_fraction", 0.585}, {"inertial_loosening", 1.0 / 3.0}};
  return soil;
}

/// The same under a liquid.
Soil immersed(double solid_fraction, double dilatancy) {
  Soil soil = beads(solid_fraction, dilatancy);
  soil.initial_saturation = 1.0;
  return soil;
}
constexpr double oil = 0.012;  // Pa s: twelve times that of water

std::unique_ptr<ConstitutiveModel> model_of(const Soil& soil) { return make_constitutive(MaterialName{"mu_i"}, soil); }

Tensor from_all_sides(double pressure) {
  Tensor stress = Tensor::Zero();
  stress.head<3>().setConstant(-pressure);
  return stress;
}

struct Numbers {
  double inertial, viscous;
};
Numbers numbers(const Soil& soil, double rate, double pressure, double viscosity = oil) {
  return {rate * soil.own("grain_diameter") * std::sqrt(soil.grain_density / pressure),
          soil.initial_saturation * viscosity * rate / pressure};
}
double friction(const Soil& soil, const Numbers& at) {
  const double m = at.inertial / soil.own("inertial_number") + at.viscous / soil.own("viscous_number");
  return soil.own("static_friction") + (soil.own("limiting_friction") - soil.own("static_friction")) * m / (1.0 + m);
}
double packing(const Soil& soil, const Numbers& at) {
  return soil.own("critical_solid_fraction") /
         (1.0 + std::sqrt(at.viscous) + soil.own("inertial_loosening") * at.inertial);
}

/// Simple shear, drained: the steady shear stress is mu(I) p or mu(J) p at any rate, dry or immersed.
TEST(MuI, ShearsSteadilyAtTheFrictionOfItsRate) {
  const LaboratoryTest& shear = laboratory_test("simple_shear");
  for (const Soil& soil : {beads(), immersed(0.6, 0.0)})
    for (const double pressure : {10.0, 1000.0})
      for (const double rate : {0.01, 1.0, 100.0}) {
        const auto model = model_of(soil);
        Element sample(soil, *model, from_all_sides(pressure), oil);
        for (int k = 0; k < 400; ++k) sample.strain_by(shear, 1e-4, 1e-4 / rate);
        EXPECT_NEAR(sample.stress()[3] / pressure, friction(soil, numbers(soil, rate, pressure)), 1e-8)
            << pressure << " " << rate;
        EXPECT_NEAR(sample.state()[0], rate, 1e-7 * rate);
        EXPECT_NEAR(sample.void_ratio(), soil.porosity / (1.0 - soil.porosity), 1e-9);
      }
}

/// Sheared under a constant mean pressure and free to swell on all sides alike, soil dilates or contracts by d phi /
/// d gamma = -K_psi phi (phi - phi_eq), a logistic curve, to the packing of its rate, and bears (mu + tan psi) p on the
/// way. (In simple shear between walls dilation is a vertical strain, which turns the deviator.)
TEST(MuI, ApproachesItsPackingByTheLogisticCurve) {
  constexpr double pressure = 200.0, dilatancy = 4.0, step = 2e-4;
  for (const double from : {0.55, 0.6})
    for (const double rate : {1e-3, 3.0}) {
      const Soil soil = immersed(from, dilatancy);
      const auto model = model_of(soil);
      const double bulk = Elasticity::of(soil).bulk;
      const Numbers at = numbers(soil, rate, pressure);
      const double to = packing(soil, at);
      Tensor stress = from_all_sides(pressure);
      std::vector<double> state(1);
      double phi = from, worst = 0.0;
      for (int k = 1; k <= 5000; ++k) {
        double swelling = dilatancy * (phi - to) * step;  // volumetric strain that keeps the pressure
        Tensor end;
        std::vector<double> reached;
        for (int round = 0; round < 30; ++round) {
          end = stress;
          reached = state;
          Tensor strain = from_all_sides(-swelling / 3.0);
          strain[3] = 0.5 * step;
          model->advance(end, strain, {1.0, 1.0 / phi - 1.0, step / rate, oil}, reached);
          const double missing = pressure + trace(end) / 3.0;
          if (std::abs(missing) < 1e-9 * pressure) break;
          swelling -= missing / bulk;
        }
        stress = end;
        state = reached;
        if (k > 10) {
          EXPECT_NEAR(stress[3] / pressure, friction(soil, at) + dilatancy * (phi - to), 2e-4);
        }
        phi *= std::exp(-swelling);
        const double due = to / (1.0 - (1.0 - to / from) * std::exp(-dilatancy * to * step * k));
        worst = std::max(worst, std::abs(phi - due));
      }
      EXPECT_LT(worst, 1e-4) << from << " " << rate;
    }
}

/// Sheared at constant volume, soil finds the pressure at which its packing is that of its rate: J = (phi_c / phi -
/// 1)^2. Loose soil loses nearly all of it, and the pore water bears the difference; in denser soil it rises.
TEST(MuI, AtConstantVolumeFindsThePressureOfItsPacking) {
  const LaboratoryTest& shear = laboratory_test("simple_shear_undrained");
  for (const double phi : {0.5, 0.55, 0.58}) {
    Soil soil = immersed(phi, 4.0);
    soil.own_numbers["inertial_loosening"] = 0.0;
    const auto model = model_of(soil);
    constexpr double pressure = 100.0, rate = 2.0;
    Element sample(soil, *model, from_all_sides(pressure), oil);
    for (int k = 0; k < 20000; ++k) sample.strain_by(shear, 1e-4, 1e-4 / rate);
    const double root = 0.585 / phi - 1.0, due = oil * rate / (root * root);
    EXPECT_NEAR(sample.pressure(), due, 1e-6 * due) << phi;
    EXPECT_NEAR(sample.stress()[3] / due, friction(soil, numbers(soil, rate, due)), 1e-6);
    EXPECT_EQ(sample.excess_pore_pressure(shear) > 0.0, phi < 0.57);
  }
}

/// Very slow shear is that of Drucker and Prager with the friction mu_s + tan psi.
TEST(MuI, SlowlyIsDruckerPrager) {
  Soil soil = beads(0.6, 3.0), coulomb = soil;
  const double dilation = 3.0 * (0.6 - 0.585);
  coulomb.cone = Soil::Cone::repose;
  coulomb.friction_angle = std::atan(0.38 + dilation) * 180.0 / std::numbers::pi;
  // alpha_psi = tan psi / 3 on the cone; fit_cone makes it of an angle.
  const double third = dilation / 3.0, tangent = 3.0 * third / std::sqrt(1.0 - 12.0 * third * third);
  coulomb.dilation_angle = std::atan(tangent) * 180.0 / std::numbers::pi;
  const auto slow = model_of(soil), cone = make_constitutive(MaterialName::drucker_prager, coulomb);
  Tensor a = from_all_sides(150.0), b = a;
  const Condition condition{0.0, 0.4 / 0.6, infinite};
  std::vector<double> state(1);
  for (int k = 0; k < 100; ++k) {
    Tensor strain;
    strain << 1e-5, -2e-5, 0.0, 3e-5, 0.0, 0.0;
    const double x = slow->advance(a, strain, condition, state), y = cone->advance(b, strain, condition, {});
    EXPECT_NEAR(x, y, 1e-3 * y + 1e-9);
    EXPECT_NEAR(trace(a), trace(b), 1e-3 * 450.0);
    EXPECT_NEAR(root_j2(a), root_j2(b), 1e-3 * 150.0);
  }
  EXPECT_EQ(state[0], 0.0);
}

/// The equations integrated by brute force: the rate of plastic shear is the one at which the soil bears its stress,
/// and stresses follow explicitly in very short steps. Implicit steps 25 and 100 times as long must agree.
struct Plainly {
  const Soil& soil;
  double solid_fraction, viscosity;
  [[nodiscard]] double borne(double rate, double pressure) const {
    const Numbers at = numbers(soil, rate, pressure, viscosity);
    return (friction(soil, at) + soil.own("dilatancy") * (solid_fraction - packing(soil, at))) * pressure;
  }
  void follow(Tensor& stress, const Tensor& strain, double duration, int steps) const {
    const Elasticity elastic = Elasticity::of(soil);
    const double dt = duration / steps;
    for (int k = 0; k < steps; ++k) {
      const double pressure = -trace(stress) / 3.0, shear = root_j2(stress);
      double rate = 0.0, high = 1e5;
      if (shear > borne(0.0, pressure)) {
        for (int round = 0; round < 60; ++round) {
          const double middle = 0.5 * (rate + high);
          (borne(middle, pressure) < shear ? rate : high) = middle;
        }
      }
      const double psi =
          soil.own("dilatancy") * (solid_fraction - packing(soil, numbers(soil, rate, pressure, viscosity)));
      Tensor plastic = shear > 0.0 ? Tensor(0.5 * rate * dt / shear * deviator(stress)) : Tensor::Zero().eval();
      for (int d = 0; d < 3; ++d) plastic[d] += rate * dt * psi / 3.0;
      elastic.add_stress(Tensor(strain / steps - plastic).data(), stress.data());
    }
  }
};

TEST(MuI, IsAPlainIntegrationOfItsEquations) {
  for (const double phi : {0.57, 0.6}) {
    Soil soil = immersed(phi, 4.0);
    soil.youngs_modulus = 1e5;
    const auto model = model_of(soil);
    constexpr double honey = 1.0;  // Pa s: relaxes so slowly that many steps resolve it
    const Plainly plainly{soil, phi, honey};
    double error[2];
    for (int finer = 0; finer < 2; ++finer) {
      Tensor found = from_all_sides(100.0), due = found;
      std::vector<double> state(1);
      const int steps = finer ? 400 : 100;
      error[finer] = 0.0;
      for (int k = 0; k < steps; ++k) {
        Tensor strain;
        strain << 1e-5, -1e-5, 0.0, 4e-5, 0.0, 0.0;
        strain *= 100.0 / steps;
        const double duration = 2e-4 * 100.0 / steps;
        model->advance(found, strain, {1.0, 1.0 / phi - 1.0, duration, honey}, state);
        plainly.follow(due, strain, duration, 10000 / steps);
        error[finer] = std::max(error[finer], (found - due).norm() / due.norm());
      }
    }
    EXPECT_LT(error[0], 0.01) << phi;
    EXPECT_LT(error[1], 0.4 * error[0]) << "first order in the step";
  }
}

/// Whatever stress and strain, soil ends where it bears its stress at its rate, without tension.
TEST(MuI, EndsWhereItBearsItsStress) {
  std::mt19937 random(3);
  std::uniform_real_distribution<> any(-1.0, 1.0);
  std::size_t flows = 0;
  for (int k = 0; k < 3000; ++k) {
    const double phi = 0.55 + 0.1 * any(random);
    const Soil soil = immersed(phi, 4.0);
    const auto model = model_of(soil);
    Tensor stress = from_all_sides(60.0 * (1.0 + any(random))), strain;
    for (int c = 0; c < 6; ++c) {
      stress[c] += 20.0 * any(random);
      strain[c] = std::pow(10.0, -5.0 + 2.0 * any(random)) * any(random);
    }
    std::vector<double> state{std::pow(10.0, 2.0 * any(random))};
    model->advance(stress, strain, {1.0, 1.0 / phi - 1.0, std::pow(10.0, -4.0 + any(random)), oil}, state);
    const double pressure = -trace(stress) / 3.0, shear = root_j2(stress), rate = state[0];
    EXPECT_GE(pressure, -1e-12);
    if (pressure < 1e-9) {
      EXPECT_LT(shear, 1e-9);
      continue;
    }
    const double borne = Plainly{soil, phi, oil}.borne(rate, pressure);
    if (rate > 0.0) {
      EXPECT_NEAR(shear, std::max(0.0, borne), 1e-6 * (1.0 + shear));
      ++flows;
    } else {
      EXPECT_LE(shear, borne * (1.0 + 1e-12));
    }
  }
  EXPECT_GT(flows, 500u);
}

/// Where other code has changed a stress and no time passes, only what no rate could bear is removed.
TEST(MuI, RemovesWithoutTimeOnlyWhatNoRateBears) {
  const Soil soil = beads();
  const auto model = model_of(soil);
  std::vector<double> state{12.0};
  const auto returned = [&](double pressure, double shear) {
    Tensor stress = from_all_sides(pressure);
    stress[3] = shear;
    model->advance(stress, Tensor::Zero(), {0.0, 0.4 / 0.6, 0.0}, state);
    return stress;
  };
  EXPECT_EQ(returned(100.0, 60.0)[3], 60.0);
  EXPECT_NEAR(returned(100.0, 70.0)[3], 64.0, 1e-12);
  EXPECT_LT(returned(-5.0, 1.0).norm(), 1e-12);
  EXPECT_EQ(state[0], 12.0);
  Tensor apart = from_all_sides(10.0);
  model->advance(apart, Tensor(-1e-3 * from_all_sides(1.0)), {0.0, 0.4 / 0.6, 1.0}, state);
  EXPECT_LT(apart.norm(), 1e-12) << "expansion in time";
}

}  // namespace
}  // namespace poretwin::solid
