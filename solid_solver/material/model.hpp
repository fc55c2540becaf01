// The one interface of constitutive models. A new model is one file that implements it and one row in registry.cpp
// (docs/extending/material.md).
#pragma once

#include "common/case/materials.hpp"
#include "common/core/lanes.hpp"
#include "solid_solver/material/stress.hpp"

#include <algorithm>
#include <memory>
#include <span>

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
  /// Safe tangent constrained modulus [Pa] while yielding: without the shear part, never below half of M.
  [[nodiscard]] double yielding() const { return std::max(bulk, 0.5 * constrained()); }
  /// Adds the stress increment [Pa] of a strain increment: K tr(e) 1 + 2 G dev(e), Eq. (86) with its deviatoric rate;
  /// of one particle or of four (Number: double or Lanes).
  template <class Number>
  [[gnu::always_inline]] void add_stress(const Number* strain, Number* stress) const {
    const Number volumetric = strain[0] + strain[1] + strain[2];
    for (int d = 0; d < 6; ++d) stress[d] += 2.0 * shear * strain[d];
    for (int d = 0; d < 3; ++d) stress[d] += (bulk - 2.0 / 3.0 * shear) * volumetric;
  }
};

/// What surrounds the soil and its strength may depend on.
struct Condition {
  double saturation = 0.0;  ///< degree of saturation s_r
  double void_ratio = 0.0;  ///< e = n / (1 - n)
};

/// Four particles of one soil, one in each lane: what a model advances, its inputs and its result.
struct Four {
  Lanes stress[6];               ///< Pa, in the order of Tensor
  Lanes strain[6];               ///< of the increment
  Lanes saturation, void_ratio;  ///< see Condition
  Lanes plastic;                 ///< result: the increment of equivalent deviatoric plastic strain
  Quad* state = nullptr;         ///< state_size() numbers, advanced like the stress
};

/// Effective stress from strain increments. Rotation is the caller's business (Jaumann rate). What a model remembers of
/// a particle besides the stress, its state, lies with the particle: it moves with it, and is saved and restored.
class ConstitutiveModel {
 public:
  ConstitutiveModel() = default;
  ConstitutiveModel(const ConstitutiveModel&) = delete;
  ConstitutiveModel& operator=(const ConstitutiveModel&) = delete;
  virtual ~ConstitutiveModel() = default;
  /// How many numbers the state of a particle has. Spans of a state below may be longer; the first numbers count.
  [[nodiscard]] virtual std::size_t state_size() const { return 0; }
  /// The state of soil that nothing has strained.
  virtual void initial(std::span<double> /*state*/) const {}
  /// Advances `stress` [Pa] and `state` by a strain increment; returns the equivalent deviatoric plastic strain it
  /// took.
  virtual double advance(Tensor& stress, const Tensor& strain, const Condition& condition,
                         std::span<double> state) const = 0;
  double advance(Tensor& stress, const Tensor& strain, const Condition& condition = {}) const {
    return advance(stress, strain, condition, {});
  }
  /// The same of many particles; this one takes them one by one.
  virtual void advance(std::span<Four> many) const;
  /// Elastic moduli in this state: the stiffness that waves, the water and the search for equilibrium meet.
  [[nodiscard]] virtual Elasticity moduli(std::span<const double> state) const = 0;
  [[nodiscard]] Elasticity initial_moduli() const;
  /// The largest moduli of any state that the soil may reach: the substep is chosen for their waves.
  [[nodiscard]] virtual Elasticity stiffest() const { return initial_moduli(); }
};

using MaterialFactory = std::unique_ptr<ConstitutiveModel> (*)(const Soil&);

/// Adds a row to the table of materials, for a model that one program has beside the others: before it reads a case.
bool add_material(Material row, MaterialFactory make);

/// The material of this name, for one soil.
std::unique_ptr<ConstitutiveModel> make_constitutive(MaterialName model, const Soil& soil);

}  // namespace poretwin::solid
