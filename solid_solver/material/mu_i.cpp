#include "solid_solver/material/mu_i.hpp"

#include "solid_solver/material/local_factor.hpp"
#include "solid_solver/numerics/material.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace poretwin::solid {

/// The end of one increment of strain as a function of the plastic shear strain x in it.
struct MuI::Flow {
  const MuI& soil;
  Moduli<InOnes> moduli;         ///< Pa
  double solid_fraction;         ///< phi
  double inertial, viscous;      ///< sqrt(Pa), Pa: I sqrt(p) / x and J p / x
  double trial, trial_pressure;  ///< Pa, sqrt(J2) and p without plastic strain
  double pressure = 0.0;         ///< Pa, p at the end
  double ratio = 0.0;            ///< mu + tan psi at the end

  /// m at a pressure [Pa], over x.
  [[nodiscard]] double rate_number(double p) const {
    return inertial / (std::sqrt(p) * soil.inertial_half_) + viscous / (p * soil.viscous_half_);
  }
  /// mu + tan psi for m and for the part of phi_eq that depends on the rate, sqrt(J) + b I; soil that contracts fast
  /// has no strength.
  void set_ratio(double m, double loosening) {
    const double dilation = soil.dilatancy_ * (solid_fraction - soil.critical_ / (1.0 + loosening));
    ratio = std::max(0.0, soil.static_friction_ + soil.gained_friction_ * m / (1.0 + m) + dilation);
  }

  /// Sets pressure and ratio. The pressure p = p_trial + bulk modulus times tan psi x depends on itself through J and
  /// I: with w = sqrt(p) and sqrt(J) + b I = g / w it is the positive root of w^3 + g w^2 + (A phi_c - B) w - B g,
  /// where A = bulk modulus times K_psi x and B = p_trial + A phi. The cubic is convex, so that Newton's iteration
  /// falls to the root from above; it starts from the last root, or from sqrt(B), which lies above the new one.
  void at(double x) {
    const double a = moduli.bulk * soil.dilatancy_ * x, b = trial_pressure + a * solid_fraction;
    double w = std::sqrt(pressure);
    pressure = ratio = 0.0;
    if (b <= 0.0) return;  // the grains are apart
    const double g = std::sqrt(viscous * x) + soil.loosening_ * inertial * x, linear = a * soil.critical_ - b;
    if (g == 0.0) w = std::sqrt(std::max(0.0, -linear));
    const auto slope = [&] { return (3.0 * w + 2.0 * g) * w + linear; };
    if (!(slope() > 0.0)) w = std::sqrt(b);
    for (int round = 0; g > 0.0 && round < mu_i::rounds; ++round) {
      const double step = (((w + g) * w + linear) * w - b * g) / slope();
      w -= step;
      if (std::abs(step) <= mu_i::reached * w) break;
    }
    if (w <= 0.0) return;
    pressure = w * w;
    set_ratio(rate_number(pressure) * x, g / w);
  }

  /// sqrt(J2) less what the soil bears [Pa].
  double excess(double x) {
    at(x);
    return trial - moduli.shear * x - ratio * pressure;
  }

  /// Finds the plastic shear strain at which the soil bears its stress, and leaves pressure and ratio there: by regula
  /// falsi (Illinois) between no plastic shear and all that removes the shear stress. With the pressure and tan psi as
  /// they are the excess is a quadratic equation, whose root is the first guess, exact without dilatancy. last: plastic
  /// shear strain to be expected.
  double find(double last) {
    double low = 0.0, high = trial / moduli.shear, above = excess(low);
    if (above <= 0.0) return 0.0;
    double next = 0.5 * high;
    if (pressure > 0.0) {
      const double c = rate_number(pressure), root = std::sqrt(pressure);
      set_ratio(0.0, (std::sqrt(viscous * last) + soil.loosening_ * inertial * last) / root);
      const double f = trial - ratio * pressure;
      const double half = 0.5 * (moduli.shear + c * (soil.gained_friction_ * pressure - f));
      if (f > 0.0) next = f / (half + std::sqrt(half * half + moduli.shear * c * f));
    }
    double below = excess(high);
    if (below >= 0.0) return high;  // nothing presses the grains together
    int side = 0;                   // of the last two points
    for (int round = 0; round < mu_i::rounds; ++round) {
      const double value = excess(next);
      if (std::abs(value) <= mu_i::reached * trial || high - low <= mu_i::reached * high) break;
      if (value > 0.0) {
        low = next;
        above = value;
        if (side > 0) below *= 0.5;
        side = 1;
      } else {
        high = next;
        below = value;
        if (side < 0) above *= 0.5;
        side = -1;
      }
      next = low + (high - low) * above / (above - below);
    }
    return next;
  }
};

Material MuI::row() {
  return {
      "mu_i",
      Material::Strength::own,
      {{"grain_diameter", 0.0, {"m", "Mean diameter of the grains, D50."}, not_negative()},
       {"static_friction", 0.38, {"", "mu_s: shear stress over pressure in very slow shear (mu_i)."}, positive(), true},
       {"limiting_friction",
        0.64,
        {"", "mu_2: the same in very fast shear; at least `static_friction` (mu_i)."},
        positive(),
        true},
       {"inertial_number",
        0.279,
        {"", "I_0: inertial number of dry grains at which friction is half-way from mu_s to mu_2 (mu_i)."},
        positive()},
       {"viscous_number",
        0.005,
        {"", "J_0: viscous number of grains in a viscous liquid at which friction is half-way (mu_i)."},
        positive()},
       {"dilatancy",
        0.0,
        {"",
         "K_psi in tan psi = K_psi (phi - phi_eq), with the dilation angle psi and the solid fraction phi; 0: the soil "
         "shears at constant volume (mu_i)."},
        not_negative()},
       {"critical_solid_fraction",
        0.585,
        {"", "phi_c: solid fraction at which very slow shear goes on at constant volume (mu_i with `dilatancy`)."},
        between(0, true, 1, true)},
       {"inertial_loosening",
        1.0 / 3.0,
        {"", "b: phi_eq = phi_c / (1 + sqrt(J) + b I) with the viscous and inertial number (mu_i with `dilatancy`)."},
        not_negative()}},
      [](const Soil& soil, const Material::Complain& complain) {
        const auto expect = [&](bool holds, std::string_view key, const std::string& what) {
          if (!holds) complain(key, what);
        };
        const double slow = soil.own("static_friction"), fast = soil.own("limiting_friction");
        expect(soil.own("grain_diameter") > 0.0, "grain_diameter",
               "soil.model = \"mu_i\" needs it, a positive number of m, found none");
        expect(fast >= slow, "limiting_friction",
               fmt::format("expected at least the static friction of {}, found {}", slow, fast));
        const double packing = soil.own("dilatancy") * (1.0 - soil.porosity - soil.own("critical_solid_fraction"));
        expect(slow + packing > 0.0, "dilatancy",
               fmt::format("the solid fraction of {:.4g} lies so far below the critical one that static_friction and "
                           "tan psi = {:.4g} leave no strength: expected a smaller dilatancy or a denser soil",
                           1.0 - soil.porosity, packing));
      },
      false,
      [](const Soil& soil) -> std::optional<double> {
        if (soil.own("dilatancy") > 0.0) return {};
        return soil.own("static_friction");
      }};
}

MuI::MuI(const Soil& soil)
    : elasticity_(soil),
      static_friction_(soil.own("static_friction")),
      gained_friction_(soil.own("limiting_friction") - static_friction_),
      inertial_rate_(soil.own("grain_diameter") * std::sqrt(soil.grain_density)),
      inertial_half_(soil.own("inertial_number")),
      viscous_half_(soil.own("viscous_number")),
      dilatancy_(soil.own("dilatancy")),
      critical_(soil.own("critical_solid_fraction")),
      loosening_(soil.own("inertial_loosening")) {}

double MuI::local_factor(const Tensor& stress, const Condition& condition, std::span<const double> /*state*/) const {
  const double p = -trace(stress) / 3.0, tan_psi = dilatancy_ * (1.0 / (1.0 + condition.void_ratio) - critical_);
  return factor_to_yield({}, 0.0, static_friction_, root_j2(stress) - tan_psi * p, p);
}

double MuI::advance(Tensor& stress, const Tensor& strain, const Condition& condition, std::span<double> state) const {
  Moduli<InOnes> moduli;
  elasticity_.over(stress.data(), strain.data(), moduli);
  add_stress<InOnes>(moduli, strain.data(), stress.data());
  const double duration = condition.duration, per_duration = duration > 0.0 ? 1.0 / duration : 0.0,
               mean = trace(stress) / 3.0;
  Flow flow{*this,
            moduli,
            1.0 / (1.0 + condition.void_ratio),
            inertial_rate_ * per_duration,
            condition.saturation * condition.viscosity * per_duration,
            root_j2(stress),
            -mean};
  double x = 0.0;
  if (duration > 0.0) {
    x = flow.find(state[0] * duration);
    state[0] = x * per_duration;
  } else {
    // An instant is too short for plastic flow: the soil bears all that it bears in the fastest shear.
    flow.pressure = std::max(0.0, -mean);
    flow.ratio = static_friction_ + gained_friction_ + dilatancy_ * flow.solid_fraction;
    x = std::max(0.0, flow.trial - flow.ratio * flow.pressure) / moduli.shear;
  }
  if (x == 0.0 && mean <= 0.0) return 0.0;
  const double left = flow.trial > 0.0 ? 1.0 - moduli.shear * x / flow.trial : 0.0;
  for (int c = 0; c < 6; ++c) stress[c] = left * (c < 3 ? stress[c] - mean : stress[c]) - (c < 3 ? flow.pressure : 0.0);
  return std::max(x / std::numbers::sqrt3, std::numeric_limits<double>::min());
}

}  // namespace poretwin::solid
