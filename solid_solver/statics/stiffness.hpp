// What soil that does not yield resists displacements with, about: the preconditioner of the search for its
// equilibrium.
#pragma once

#include "solid_solver/setup.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin::solid {

/// The elastic operator without what couples the axes, (M - G) d2/dx_a2 + G lap for the displacement along axis a
/// (second derivatives: Espanol & Revenga 2003), on the soil's points as they were laid, plus a given resistance
/// [N/m] of each particle; one sparse Cholesky factor an axis. Its eigenvalues are those of the elastic operator
/// within a factor that Poisson's ratio sets, whatever the size (Korn's inequality). The factors have one pattern and
/// are kept side by side, rounded to floats: what they are multiplied to is symmetric and positive still, and solving
/// is a matter of reading them.
template <int D>
class Stiffness {
 public:
  /// lattice [m]: the places of all particles, as they were laid; others than these do not enter, so that a run that
  /// goes on from a checkpoint has the same operator to the bit.
  Stiffness(const Setup<D>& setup, const Particles<D>& particles, const VecArray<D>& lattice, ScalarArray resistance);
  /// Displacements [m] that would balance the forces [N], about.
  [[nodiscard]] VecArray<D> displacements(const VecArray<D>& forces) const;
  /// The work [J] that the forces [N] would do on these displacements. Half of the solve for them suffices.
  [[nodiscard]] double work(const VecArray<D>& forces) const;
  /// How far from rest soil is on whose forces that displacement would do this work [J]: the error of its stress in
  /// the energy's norm, over the stress that the reference acceleration [m/s2], upwards, makes.
  [[nodiscard]] double departure(double work, double reference) const {
    return std::sqrt(std::max(0.0, work) / unit_work_) / reference;
  }
  /// The resistance it was built with [N/m].
  [[nodiscard]] const ScalarArray& resistance() const { return resistance_; }

 private:
  using EachAxis = Eigen::Array<double, D, 1>;
  /// L^-1 of the forces, in the order of elimination.
  [[nodiscard]] std::vector<EachAxis> eliminated(const VecArray<D>& forces) const;
  ScalarArray resistance_;
  double unit_work_ = 0.0;           ///< J s4/m2, of unit acceleration
  std::vector<Index> place_;         ///< of each particle in the order of elimination
  std::vector<Index> offset_, row_;  ///< the factors by columns, without their diagonals
  std::vector<Eigen::Array<float, D, 1>> factor_;
  std::vector<EachAxis> inverse_;  ///< of the diagonals
};

}  // namespace poretwin::solid
