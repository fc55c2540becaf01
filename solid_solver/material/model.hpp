// The interface of all constitutive models. A new model is one file that implements it and one row in registry.cpp
// (docs/extending/material.md).
#pragma once

#include "common/case/materials.hpp"
#include "common/core/lanes.hpp"
#include "solid_solver/material/stress.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace poretwin::solid {

/// Isotropic elastic moduli [Pa].
struct Elasticity {
  double bulk = 0.0, shear = 0.0;
  static Elasticity of(const Soil& soil) {
    const double e = soil.youngs_modulus, nu = soil.poissons_ratio;
    return {e / (3.0 * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu))};
  }
  /// Constrained modulus M = K + 4 G / 3 [Pa].
  [[nodiscard]] double constrained() const { return bulk + 4.0 / 3.0 * shear; }
  /// Lower estimate of the tangent constrained modulus [Pa] during yielding: the bulk modulus, without the shear part,
  /// but at least half of M.
  [[nodiscard]] double yielding() const { return std::max(bulk, 0.5 * constrained()); }
  /// Adds the stress increment [Pa] of a strain increment.
  void add_stress(const double* strain, double* stress) const;
};

/// Elastic moduli of one particle or of four [Pa].
template <class In>
struct Moduli {
  typename In::Number bulk, shear;
};

/// Adds the stress increment [Pa] of a strain increment: K tr(e) 1 + 2 G dev(e), Eq. (86) with its deviatoric rate.
template <class In>
[[gnu::always_inline]] inline void add_stress(const Moduli<In>& moduli, const typename In::Number* strain,
                                              typename In::Number* stress) {
  const typename In::Number volumetric = strain[0] + strain[1] + strain[2];
  for (int d = 0; d < 6; ++d) stress[d] += 2.0 * moduli.shear * strain[d];
  for (int d = 0; d < 3; ++d) stress[d] += (moduli.bulk - 2.0 / 3.0 * moduli.shear) * volumetric;
}

inline void Elasticity::add_stress(const double* strain, double* stress) const {
  solid::add_stress<InOnes>({bulk, shear}, strain, stress);
}

/// The elasticity of materials with Young's modulus E: constant, or E = E_ref (p / p_ref)^m with the mean effective
/// pressure p, which is at least the soil's `least_pressure`. Poisson's ratio is constant.
class PressureElasticity {
 public:
  explicit PressureElasticity(const Soil& soil)
      : reference_(Elasticity::of(soil)),
        exponent_(soil.stiffness_exponent),
        pressure_(soil.reference_pressure),
        least_(soil.least_pressure) {}
  [[nodiscard]] bool is_constant() const { return exponent_ == 0.0; }
  [[nodiscard]] const Elasticity& reference() const { return reference_; }
  /// The moduli at a mean effective pressure [Pa].
  [[nodiscard]] Elasticity at(double pressure) const {
    if (is_constant()) return reference_;
    const double times = std::pow(std::max(pressure, least_) / pressure_, exponent_);
    return {times * reference_.bulk, times * reference_.shear};
  }
  /// The moduli for a strain increment that starts from a stress [Pa]. They are those at the pressure in the middle of
  /// the increment, computed as if the increment were elastic.
  template <class In>
  [[gnu::always_inline]] void over(const typename In::Number* stress, const typename In::Number* strain,
                                   Moduli<In>& moduli) const {
    using Number = typename In::Number;
    moduli = {Number{} + reference_.bulk, Number{} + reference_.shear};
    if (is_constant()) return;
    const auto follow = [this](double pressure) { return std::pow(std::max(pressure, least_) / pressure_, exponent_); };
    const Number before = -(stress[0] + stress[1] + stress[2]) / 3.0;
    Number times = before;
    apply(follow, times);
    times = before - 0.5 * times * reference_.bulk * (strain[0] + strain[1] + strain[2]);
    apply(follow, times);
    moduli.bulk *= times;
    moduli.shear *= times;
  }

 private:
  Elasticity reference_;
  double exponent_, pressure_, least_;
};

/// Thrown where a material finds no stress for an increment. It contains the message and the index of the particle
/// among those advanced together; the caller converts it into a DivergedError that names the particle.
struct MaterialFailure {
  std::string what;
  std::size_t place = 0;
};

/// A variable of a material's state, with its description for output.
struct StateVariable {
  std::string name, unit, meaning;
};

/// Conditions on which the soil's strength may depend.
struct Condition {
  double saturation = 0.0;  ///< degree of saturation s_r
  double void_ratio = 0.0;  ///< e = n / (1 - n)
  /// s, in which the strain increment takes place. Infinite where strains are those of a search for rest, in which no
  /// time passes; 0 where a stress that other code changed is brought back to what the soil can carry.
  double duration = std::numeric_limits<double>::infinity();
  double viscosity = 0.0;  ///< Pa s, dynamic viscosity of the water
};

/// Four particles of one soil, one per lane, with the inputs and results of a model's advance().
struct Four {
  Lanes stress[6];                                                             ///< Pa, in the order of Tensor
  Lanes strain[6];                                                             ///< strain increment
  Lanes saturation, void_ratio;                                                ///< see Condition
  double duration = std::numeric_limits<double>::infinity(), viscosity = 0.0;  ///< s, Pa s, see Condition
  Lanes plastic;          ///< result: the increment of equivalent deviatoric plastic strain
  Quad* state = nullptr;  ///< the state_size() state variables; updated together with the stress
};

/// Effective stress from strain increments. The caller rotates the stress (Jaumann rate). A particle's state consists
/// of the variables that its model stores besides the stress. It moves with the particle, and is saved and restored.
class ConstitutiveModel {
 public:
  ConstitutiveModel() = default;
  ConstitutiveModel(const ConstitutiveModel&) = delete;
  ConstitutiveModel& operator=(const ConstitutiveModel&) = delete;
  virtual ~ConstitutiveModel() = default;
  /// Number of state variables per particle. The spans of states below may be longer. A model uses only their first
  /// state_size() numbers.
  [[nodiscard]] virtual std::size_t state_size() const { return 0; }
  /// Descriptions of the first state variables. Variables without a description are not part of the output.
  [[nodiscard]] virtual std::vector<StateVariable> state_variables() const { return {}; }
  /// Sets the initial state of soil under this effective stress [Pa], before any strain.
  virtual void initial(const Tensor& /*stress*/, std::span<double> /*state*/) const {}
  /// Advances `stress` [Pa] and `state` by a strain increment; returns the equivalent deviatoric plastic strain of the
  /// increment. Throws MaterialFailure where no stress is found.
  virtual double advance(Tensor& stress, const Tensor& strain, const Condition& condition,
                         std::span<double> state) const = 0;
  double advance(Tensor& stress, const Tensor& strain, const Condition& condition = {}) const {
    return advance(stress, strain, condition, {});
  }
  /// Advances many particles. This implementation advances them one by one.
  virtual void advance(std::span<Four> many) const;
  /// Elastic moduli under this effective stress [Pa] and in this state. This stiffness enters wave speeds, the fluid's
  /// pressure solve and the search for equilibrium.
  [[nodiscard]] virtual Elasticity moduli(const Tensor& stress, std::span<const double> state) const = 0;
  /// Elastic moduli of soil before any strain, under this isotropic pressure [Pa].
  [[nodiscard]] Elasticity moduli_under(double pressure) const;
  [[nodiscard]] Elasticity initial_moduli() const { return moduli_under(0.0); }
  /// The largest moduli in any state that the soil may reach up to this mean effective pressure [Pa]. The length of
  /// substeps is chosen for waves of this stiffness.
  [[nodiscard]] virtual Elasticity stiffest(double pressure) const { return moduli_under(pressure); }
  /// Local factor of safety: the number by which the soil's present strength can be divided, as weakened() divides it,
  /// until this effective stress [Pa] lies on the yield surface. Infinite without shear stress. NaN where the model has
  /// no such strength, and in soil that has neither stress nor cohesion.
  [[nodiscard]] virtual double local_factor(const Tensor& /*stress*/, const Condition& /*condition*/,
                                            std::span<const double> /*state*/) const {
    return std::numeric_limits<double>::quiet_NaN();
  }
};

using MaterialFactory = std::unique_ptr<ConstitutiveModel> (*)(const Soil&);

/// Adds a row to the table of materials, for a model that exists in only one program. To be called before the program
/// reads a case.
bool add_material(Material row, MaterialFactory make);

/// The constitutive model with this name, for one soil. Throws CaseError where no model has the name.
std::unique_ptr<ConstitutiveModel> make_constitutive(MaterialName model, const Soil& soil);

}  // namespace poretwin::solid
