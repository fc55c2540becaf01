// Approximate stiffness of soil that does not yield: the preconditioner of the search for its equilibrium.
#pragma once

#include "solid_solver/setup.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

namespace poretwin::solid {

template <int D>
class AxisInverse;  // axis_inverse.hpp

/// The elastic operator without the terms that couple the axes, (M - G) d2/dx_a2 + G lap for the displacement along
/// axis a (constrained modulus M, shear modulus G; second derivatives by Espanol & Revenga 2003), on the soil's initial
/// points. A given resistance [N/m] of each particle is added to the diagonal.
///
/// Its eigenvalues are those of the elastic operator within a factor that depends on Poisson's ratio only, at any size
/// (Korn's inequality). In 2D it is solved by sparse Cholesky factors, in 3D, where these grow faster than the number of
/// particles, by conjugate gradients with multigrid, to a small part of the energy (AxisInverse).
template <int D>
class Stiffness {
 public:
  /// lattice [m]: initial positions of all particles. Later positions are not used, so that a resumed run has the same
  /// operator to the bit.
  Stiffness(const Setup<D>& setup, const Particles<D>& particles, const VecArray<D>& lattice, ScalarArray resistance);
  ~Stiffness();
  /// Approximate displacements [m] that balance the forces [N].
  [[nodiscard]] VecArray<D> displacements(const VecArray<D>& forces) const;
  /// The same of the particles and of the plates under a force, along their normals; on_plates: forces [N] along those.
  /// Returns the displacements of the particles, and sets those of the plates.
  [[nodiscard]] VecArray<D> displacements(const VecArray<D>& forces, const Eigen::VectorXd& on_plates,
                                          Eigen::VectorXd& plates) const;
  /// Work [J] of the forces [N] on the displacements that balance them. With factors it takes only half of their solve.
  [[nodiscard]] double work(const VecArray<D>& forces) const;
  /// Departure from rest [1] for forces that do this work [J] on their displacements: the error of the stress in the
  /// norm of the elastic energy, over the stress that the reference acceleration [m/s2] causes when it acts upwards.
  [[nodiscard]] double departure(double work, double reference) const {
    return std::sqrt(std::max(0.0, work) / unit_work_) / reference;
  }
  /// The resistance of each particle that it was built with [N/m].
  [[nodiscard]] const ScalarArray& resistance() const { return resistance_; }

 private:
  ScalarArray resistance_;
  double unit_work_ = 0.0;  ///< J s4/m2, work of the forces of unit acceleration
  std::unique_ptr<AxisInverse<D>> inverse_;
  /// For each plate that a force moves. border_: force on each particle per displacement of the plate along its normal
  /// [N/m]; follow_: displacements of the particles under these forces, per displacement of the plate [1].
  std::vector<VecArray<D>> border_, follow_;
  Eigen::MatrixXd compliance_;  ///< m/N, displacements of the plates per force on them, with the soil following
};

}  // namespace poretwin::solid
