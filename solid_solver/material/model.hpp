// The one interface of constitutive models. A new model is one file that implements it and one line in registry.cpp.
#pragma once

#include "common/case/case.hpp"
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
  /// Adds the stress increment [Pa] of a strain increment: K tr(e) 1 + 2 G dev(e), Eq. (86) with its deviatoric rate;
  /// of one particle or of four (Number: double or Lanes).
  template <class Number>
  [[gnu::always_inline]] void add_stress(const Number* strain, Number* stress) const {
    const Number volumetric = strain[0] + strain[1] + strain[2];
    for (int d = 0; d < 6; ++d) stress[d] += 2.0 * shear * strain[d];
    for (int d = 0; d < 3; ++d) stress[d] += (bulk - 2.0 / 3.0 * shear) * volumetric;
  }
};

/// The state of the soil that its strength depends on, besides its stress.
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
};

/// Effective stress from strain increments. Rotation is the caller's business (Jaumann rate).
class ConstitutiveModel {
 public:
  explicit ConstitutiveModel(const Elasticity& elasticity) : elasticity_(elasticity) {}
  ConstitutiveModel(const ConstitutiveModel&) = delete;
  ConstitutiveModel& operator=(const ConstitutiveModel&) = delete;
  virtual ~ConstitutiveModel() = default;
  /// Advances `stress` [Pa] by a strain increment; returns the equivalent deviatoric plastic strain it took.
  virtual double advance(Tensor& stress, const Tensor& strain, const Condition& condition = {}) const = 0;
  /// The same of many particles; this one takes them one by one.
  virtual void advance(std::span<Four> many) const;
  [[nodiscard]] const Elasticity& elasticity() const { return elasticity_; }
  /// Safe tangent constrained modulus [Pa] while yielding: without the shear part, never below half of M.
  [[nodiscard]] double yielding_modulus() const { return std::max(elasticity_.bulk, 0.5 * elasticity_.constrained()); }

 private:
  Elasticity elasticity_;
};

/// The model named by solid.model, for one soil.
std::unique_ptr<ConstitutiveModel> make_constitutive(SolidCase::Model model, const Soil& soil);

}  // namespace poretwin::solid
