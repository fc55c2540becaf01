// An erosion law: the speed at which the surface of soil retreats under the shear stress of water that runs over it.
// Each law has one file and one row in `erosion_laws`. Its parameters become keys of [soil.erosion] automatically.
#pragma once

#include "common/case/case.hpp"
#include "common/media/seepage_law.hpp"

#include <deque>
#include <span>
#include <string>
#include <vector>

namespace poretwin::porous {

struct ErosionLaw {
  std::string name;     ///< erosion.model
  std::string meaning;  ///< for docs/case-file.md
  std::vector<LawParameter> parameters = {};
  /// Speed [m/s] of the surface, into the soil and normal to it, under a shear stress [Pa]; parameters: in the order
  /// above.
  double (*speed)(double shear_stress, std::span<const double> parameters) = nullptr;
};

/// All laws; the first is the default. References to them remain valid.
const std::deque<ErosionLaw>& erosion_laws();

/// How free water erodes a soil.
class Erosion {
 public:
  /// Of soil that has [soil.erosion]. density [kg/m3]: of the water.
  Erosion(const ErosionCase& given, double density);
  /// Shear stress [Pa] of water that runs over the soil's surface with this speed [m/s]: f / 8 rho u^2, with the
  /// friction factor f of Darcy and Weisbach. u is the mean velocity over the depth.
  [[nodiscard]] double shear_stress(double speed) const { return 0.125 * friction_factor_ * density_ * speed * speed; }
  /// Speed [m/s] at which the surface retreats under a shear stress [Pa].
  [[nodiscard]] double speed(double shear_stress) const { return law_->speed(shear_stress, parameters_); }

 private:
  const ErosionLaw* law_;
  std::vector<double> parameters_;
  double friction_factor_, density_;
};

}  // namespace poretwin::porous
