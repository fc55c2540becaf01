// A single point of soil in a laboratory test: a path of strain and stress, without particles.
#pragma once

#include "solid_solver/material/model.hpp"

#include <string_view>
#include <vector>

namespace poretwin::solid {

/// A test: it keeps certain stresses and strains constant while the sample is compressed along y or sheared in the
/// plane xy.
struct LaboratoryTest {
  std::string_view name;     ///< name for --test
  std::string_view meaning;  ///< description in one line
  bool shears;               ///< gamma_xy or s_xy is controlled, instead of the axial strain or stress
  bool undrained;            ///< at constant volume
};
const std::vector<LaboratoryTest>& laboratory_tests();
/// The test of this name. Throws CaseError where no test has the name.
const LaboratoryTest& laboratory_test(std::string_view name);

/// A soil sample. Stresses are effective, tension positive; strains are logarithmic.
class Element {
 public:
  /// viscosity [Pa s]: that of the water in its pores.
  Element(const Soil& soil, const ConstitutiveModel& model, const Tensor& stress, double viscosity = 0.0);
  /// Applies an increment `step` of the axial strain (tension positive) or of gamma_xy, in `duration` [s]; infinite: so
  /// slowly that the rate does not matter. Throws DivergedError where no strain satisfies the conditions of the test.
  void strain_by(const LaboratoryTest& test, double step, double duration = std::numeric_limits<double>::infinity());
  /// Strains the sample, slowly, until the axial stress (in undrained tests s_yy - s_xx), or s_xy, is `target` [Pa].
  /// Throws DivergedError where the soil cannot bear this stress.
  void load_to(const LaboratoryTest& test, double target);

  [[nodiscard]] const Tensor& stress() const { return stress_; }
  [[nodiscard]] const Tensor& strain() const { return strain_; }
  [[nodiscard]] std::span<const double> state() const { return state_; }
  [[nodiscard]] double plastic_strain() const { return plastic_; }
  [[nodiscard]] double void_ratio() const;
  /// Mean effective pressure, compression positive, and deviator sqrt(3 J2) [Pa].
  [[nodiscard]] double pressure() const { return -trace(stress_) / 3.0; }
  [[nodiscard]] double deviator_stress() const { return std::sqrt(3.0) * root_j2(stress_); }
  /// Excess pore pressure [Pa] in an undrained test, for a constant lateral (in shear: vertical) total stress: the
  /// decrease of the effective stress.
  [[nodiscard]] double excess_pore_pressure(const LaboratoryTest& test) const;

 private:
  struct Control;
  void follow(const Control& control, double duration);
  const ConstitutiveModel& model_;
  Tensor start_, stress_, strain_ = Tensor::Zero();
  std::vector<double> state_;
  double plastic_ = 0.0, initial_void_ratio_, saturation_, viscosity_;
};

}  // namespace poretwin::solid
