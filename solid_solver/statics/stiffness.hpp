// Approximate stiffness of soil that does not yield. It preconditions the search for an equilibrium of the soil.
#pragma once

#include "solid_solver/setup.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

namespace poretwin::solid {

template <int D>
class AxisInverse;  // axis_inverse.hpp

/// The elastic operator without the terms that couple the axes: (M - G) d2/dx_a2 + G lap for the displacement along
/// axis a. M is the constrained modulus, G the shear modulus; second derivatives are those of Espanol & Revenga (2003)
/// on the soil's initial points. A given resistance [N/m] of each particle is added to the diagonal.
///
/// Its eigenvalues equal those of the elastic operator within a factor that depends only on Poisson's ratio, for any
/// size of the soil (Korn's inequality). It is solved in 2D by sparse Cholesky factors. In 3D, where these grow faster
/// than the number of particles, it is solved by conjugate gradients with multigrid, to a small part of the energy.
template <int D>
class Stiffness {
 public:
  /// lattice [m]: initial positions of all particles. Later positions are not used, so that the operator of a resumed
  /// run is bitwise the same.
  Stiffness(const Setup<D>& setup, const Particles<D>& particles, const VecArray<D>& lattice, ScalarArray resistance);
  ~Stiffness();
  /// Approximate displacements [m] that balance the forces [N].
  [[nodiscard]] VecArray<D> displacements(const VecArray<D>& forces) const;
  /// Approximate displacements [m] of the particles (returned) and in the freedoms of the plates (`plates`: along their
  /// normals, or of their ends as they turn) that balance forces on both. on_plates: forces [N] in these freedoms.
  [[nodiscard]] VecArray<D> displacements(const VecArray<D>& forces, const Eigen::VectorXd& on_plates,
                                          Eigen::VectorXd& plates) const;
  /// Work [J] of the forces [N] on the displacements that balance them. With factors it needs only half of the solve.
  [[nodiscard]] double work(const VecArray<D>& forces) const;
  /// Departure from rest [1] for forces that do `work` [J] on the displacements that balance them: the error of the
  /// stress in the norm of the elastic energy, over the stress that the reference acceleration [m/s2] causes upwards.
  [[nodiscard]] double departure(double work, double reference) const {
    return std::sqrt(std::max(0.0, work) / unit_work_) / reference;
  }
  /// The resistance of each particle with which the stiffness was built [N/m].
  [[nodiscard]] const ScalarArray& resistance() const { return resistance_; }

 private:
  ScalarArray resistance_;
  double unit_work_ = 0.0;  ///< J s4/m2, work of the forces of unit acceleration
  std::unique_ptr<AxisInverse<D>> inverse_;
  /// For each freedom of the plates. border_: force on each particle per displacement in this freedom [N/m]; follow_:
  /// displacements of the particles under these forces, per displacement in this freedom [1].
  std::vector<VecArray<D>> border_, follow_;
  Eigen::MatrixXd compliance_;  ///< m/N, displacements of the plates per force on them; the soil responds
};

}  // namespace poretwin::solid
