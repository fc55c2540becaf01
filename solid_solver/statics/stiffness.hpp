// Approximate stiffness of soil that does not yield: the preconditioner of the search for its equilibrium.
#pragma once

#include "solid_solver/setup.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin::solid {

/// The elastic operator without the terms that couple the axes, (M - G) d2/dx_a2 + G lap for the displacement along
/// axis a (second derivatives: Espanol & Revenga 2003), on the soil's initial points, plus a given resistance [N/m] of
/// each particle; one sparse Cholesky factor an axis. Its eigenvalues are those of the elastic operator within a factor
/// that Poisson's ratio sets, whatever the size (Korn's inequality). The factors have one pattern and are stored
/// interleaved, in floats: their product stays symmetric and positive, and the time of a solve is that of reading them.
template <int D>
class Stiffness {
 public:
  /// lattice [m]: initial positions of all particles. No later ones enter, so that a resumed run has the same operator
  /// to the bit.
  Stiffness(const Setup<D>& setup, const Particles<D>& particles, const VecArray<D>& lattice, ScalarArray resistance);
  /// Approximate displacements [m] that balance the forces [N].
  [[nodiscard]] VecArray<D> displacements(const VecArray<D>& forces) const;
  /// The work [J] that the forces [N] would do on these displacements. Half of the solve for them suffices.
  [[nodiscard]] double work(const VecArray<D>& forces) const;
  /// Departure from rest, for forces that do this work [J] on their displacements: the error of stress in the energy's
  /// norm, over the stress that the reference acceleration [m/s2], upwards, makes.
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
