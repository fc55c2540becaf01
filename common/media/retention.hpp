// The retention curve of a soil as the flow of its water needs it: with the integral of its permeability, and in a
// variable in which Newton's steps are good.
#pragma once

#include "common/media/retention_law.hpp"

namespace poretwin::porous {

class Retention {
 public:
  explicit Retention(std::unique_ptr<RetentionCurve> curve);

  /// S_e at a pressure head [m].
  [[nodiscard]] Rate saturation(double psi) const { return psi < 0.0 ? curve_->saturation(psi) : Rate{1.0, 0.0}; }
  /// k_r.
  [[nodiscard]] Rate permeability(double psi) const { return psi < 0.0 ? curve_->permeability(psi) : Rate{1.0, 0.0}; }
  /// Phi = integral of k_r from 0 to psi [m] (Kirchhoff 1894): without gravity the flux is -K grad Phi. From a table
  /// of its values and slopes, joined by cubics.
  [[nodiscard]] double potential(double psi) const;

  /// The switched variable u of Brenner & Cances (2017): S_e below the head at which it rises fastest; above, linear in
  /// psi with the slope that S_e has there. In dry soil psi varies wildly with the water, near saturation the water
  /// hardly with psi: u changes evenly in both.
  [[nodiscard]] double variable(double psi) const;
  /// psi [m] and dpsi/du at u > 0.
  [[nodiscard]] Rate head(double variable) const;
  /// u at the head where the two parts meet.
  [[nodiscard]] double joint() const { return joint_.value; }

 private:
  std::unique_ptr<RetentionCurve> curve_;
  double joint_head_;                             ///< m
  Rate joint_;                                    ///< S_e there
  std::vector<double> potential_, permeability_;  ///< at the table's heads
};

/// The curve of a soil; none where it has no capillarity.
std::unique_ptr<Retention> retention_of(const Soil& soil);

/// Residual water content over porosity.
double residual_saturation(const Soil& soil);

}  // namespace poretwin::porous
