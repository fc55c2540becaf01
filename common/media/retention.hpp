// The retention curve of a soil, with the further functions that the flow solver needs: the integral of the
// permeability, and a variable in which Newton's method converges.
#pragma once

#include "common/media/retention_law.hpp"

namespace poretwin::porous {

class Retention {
 public:
  explicit Retention(std::unique_ptr<RetentionCurve> curve);

  /// Effective saturation S_e at a pressure head psi [m].
  [[nodiscard]] Rate saturation(double psi) const { return psi < 0.0 ? curve_->saturation(psi) : Rate{1.0, 0.0}; }
  /// Relative permeability k_r.
  [[nodiscard]] Rate permeability(double psi) const { return psi < 0.0 ? curve_->permeability(psi) : Rate{1.0, 0.0}; }
  /// Phi = integral of k_r from 0 to psi [m] (Kirchhoff 1894). Without gravity the flux is -K grad Phi, with the
  /// saturated conductivity K. Phi is interpolated by cubics in a table of values and slopes.
  [[nodiscard]] double potential(double psi) const;

  /// The switched variable u of Brenner & Cances (2017): S_e below the head at which S_e rises fastest; above this
  /// head, linear in psi with the slope of S_e there. In dry soil psi changes strongly with the water content; near
  /// saturation the water content hardly changes with psi. u changes evenly in both ranges.
  [[nodiscard]] double variable(double psi) const;
  /// psi [m] and dpsi/du at u > 0.
  [[nodiscard]] Rate head(double variable) const;
  /// u at the head where the two parts of u meet.
  [[nodiscard]] double joint() const { return joint_.value; }

 private:
  std::unique_ptr<RetentionCurve> curve_;
  double joint_head_;                             ///< m, head where the two parts of u meet
  Rate joint_;                                    ///< S_e at joint_head_
  std::vector<double> heads_;                     ///< m, of the table of Phi, falling from 0
  std::vector<double> potential_, permeability_;  ///< at these heads
  std::vector<std::size_t> place_;                ///< by row of even logarithms: its place in the table
};

/// The curve of a soil; nullptr if the soil has no capillarity.
std::unique_ptr<Retention> retention_of(const Soil& soil);

/// Residual water content over porosity.
double residual_saturation(const Soil& soil);

}  // namespace poretwin::porous
