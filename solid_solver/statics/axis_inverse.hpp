// Solves, separately for each axis, for the displacements at which the stiffness balances given forces.
#pragma once

#include "common/core/vector.hpp"

#include <Eigen/SparseCore>

#include <memory>

namespace poretwin::solid {

/// One symmetric positive definite matrix [N/m] per axis, all with the same sparsity pattern.
template <int D>
class AxisInverse {
 public:
  AxisInverse() = default;
  AxisInverse(const AxisInverse&) = delete;
  AxisInverse& operator=(const AxisInverse&) = delete;
  virtual ~AxisInverse() = default;
  /// Adds the matrix of the next axis. Throws DivergedError where it is not positive definite.
  virtual void add(const Eigen::SparseMatrix<double>& matrix) = 0;
  /// Displacements [m] that balance the forces [N].
  [[nodiscard]] virtual VecArray<D> displacements(const VecArray<D>& forces) const = 0;
  /// Work [J] of the forces [N] on these displacements.
  [[nodiscard]] virtual double work(const VecArray<D>& forces) const = 0;
};

/// By sparse Cholesky factors. The factors have one sparsity pattern and are stored interleaved in single precision:
/// the product of the rounded factors stays symmetric and positive definite, and a solve takes only the time of reading
/// them. In 3D their size grows with the number of particles to the power of 1.6.
template <int D>
std::unique_ptr<AxisInverse<D>> by_factors();

/// By conjugate gradients with multigrid (Multigrid), to statics::inverse_accuracy. Memory and time grow in proportion
/// to the number of particles.
template <int D>
std::unique_ptr<AxisInverse<D>> by_multigrid();

}  // namespace poretwin::solid
