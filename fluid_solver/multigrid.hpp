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
  explicit Multigrid(const PairMatrix& matrix);
  /// z = about A^-1 r. Not quite linear in r: wants the flexible form of conjugate gradients.
  void cycle(std::span<const double> r, std::span<double> z) { cycle(0, r, z); }
  [[nodiscard]] std::size_t levels() const { return levels_.size(); }

 private:
  struct Level {
    PairMatrix coarse;             ///< of the next level
    std::vector<Index> aggregate;  ///< of each row; `none`: left to the smoother
    ScalarArray residual;          ///< of this level
    ScalarArray b, x;              ///< of the next level, as the rest
    ScalarArray v, w, d, r;
  };
  static constexpr Index none = static_cast<Index>(-1);

  static std::vector<Index> match(const PairMatrix& m, Index& count);
  static PairMatrix coarsen(const PairMatrix& m, const std::vector<Index>& aggregate, std::size_t count);
  [[nodiscard]] const PairMatrix& matrix(std::size_t level) const {
    return level == 0 ? finest_ : levels_[level - 1].coarse;
  }
  void cycle(std::size_t level, std::span<const double> b, std::span<double> x);
  void correct(std::size_t level);

  const PairMatrix& finest_;
  std::vector<Level> levels_;
  Eigen::MatrixXd inverse_;  ///< of the coarsest matrix
};

}  // namespace poretwin::fluid
