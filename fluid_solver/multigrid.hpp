// Algebraic multigrid by aggregation (Notay 2010): the preconditioner of large pressure systems.
#pragma once

#include "fluid_solver/csr.hpp"

#include <Eigen/Dense>

namespace poretwin::fluid {

/// One cycle is a preconditioner: Gauss-Seidel forwards, a correction by constants on aggregates of about four rows
/// (solved by the next level, with at most two steps of conjugate gradients around it), Gauss-Seidel backwards.
/// Memory is taken when it is built, none in a cycle. The matrix must outlive it.
class Multigrid {
 public:
  using CoarseMatrix = GraphMatrix<double, Columns>;
  explicit Multigrid(const PairMatrix& matrix);
  /// z = about A^-1 r. Not quite linear in r: wants the flexible form of conjugate gradients.
  void cycle(std::span<const double> r, std::span<double> z);
  [[nodiscard]] std::size_t levels() const { return levels_.size(); }

 private:
  struct Level {
    CoarseMatrix coarse;           ///< of the next level
    std::vector<Index> aggregate;  ///< of each row; none: left to the smoother
    ScalarArray residual;          ///< of this level
    ScalarArray b, x;              ///< of the next level, as the rest
    ScalarArray v, w, d, r;
  };
  /// Adds the level below m; false where that would hardly be smaller.
  template <class Matrix>
  bool add_level(const Matrix& m);
  template <class Matrix>
  void invert(const Matrix& m);
  template <class Matrix>
  void cycle(const Matrix& m, std::size_t level, std::span<const double> b, std::span<double> x);
  void correct(std::size_t level);

  const PairMatrix& finest_;
  std::vector<Level> levels_;
  Eigen::MatrixXd inverse_;  ///< of the coarsest matrix
};

}  // namespace poretwin::fluid
