// Algebraic multigrid by aggregation (Notay 2010): the preconditioner of large pressure systems.
#pragma once

#include "common/numerics/csr.hpp"

#include <Eigen/Dense>

#include <array>

namespace poretwin {

/// A matrix in compressed rows from which a level is made. Its entries have the same signs as those of a PairMatrix.
struct WholeMatrix {
  std::vector<Index> offset{0}, index;
  ScalarArray weight, diagonal;
  [[nodiscard]] std::size_t size() const { return diagonal.size(); }
  [[nodiscard]] std::size_t begin(std::size_t a) const { return offset[a]; }
  [[nodiscard]] std::size_t end(std::size_t a) const { return offset[a + 1]; }
  [[nodiscard]] Index column(std::size_t, std::size_t k) const { return index[k]; }
};

/// The matrix of a level below the finest. It is symmetric: only the entries before the diagonal are stored for each
/// row. Products with the entries after the diagonal are added by the later rows (push), so that a sweep reads half the
/// matrix; reading dominates the cost for large matrices. Weights are rounded to single precision, and the diagonal
/// accordingly, as in a PairMatrix.
class CoarseMatrix {
 public:
  CoarseMatrix() = default;
  explicit CoarseMatrix(const WholeMatrix& whole);
  [[nodiscard]] std::size_t size() const { return diagonal_.size(); }
  [[nodiscard]] double diagonal(std::size_t a) const { return diagonal_[a]; }
  /// Sum of weight times x over the columns before row a.
  [[nodiscard]] double off_diagonal_sum(std::size_t a, const double* x) const {
    std::array<double, in_step> sum{};
    for (std::size_t k = offset_[a]; k < offset_[a + 1]; k += in_step)
      for (std::size_t l = 0; l < in_step; ++l) sum[l] += static_cast<double>(weight_[k + l]) * x[column_[k + l]];
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
  }
  /// Adds weight times x to y in the rows of the columns before row a.
  void push(std::size_t a, double x, double* y) const {
    for (std::size_t k = offset_[a]; k < offset_[a + 1]; k += in_step)
      for (std::size_t l = 0; l < in_step; ++l) y[column_[k + l]] += static_cast<double>(weight_[k + l]) * x;
  }

 private:
  static constexpr std::size_t in_step = 4;  ///< rows are padded with zeros to a multiple of this
  std::vector<Index> offset_{0}, column_;
  std::vector<float> weight_;
  ScalarArray diagonal_;
};

/// One cycle is a preconditioner: Gauss-Seidel forwards, a correction that is constant on each aggregate of about four
/// unknowns (the coarse space), Gauss-Seidel backwards. The system for these constants is solved by at most two steps
/// of conjugate gradients with a cycle of the next level as preconditioner. All memory is allocated in the constructor.
/// The matrix must outlive this object.
class Multigrid {
 public:
  explicit Multigrid(const PairMatrix& matrix);
  /// z is approximately A^-1 r. It is slightly nonlinear in r, and so needs flexible conjugate gradients.
  void cycle(std::span<const double> r, std::span<double> z);
  [[nodiscard]] std::size_t levels() const { return levels_.size(); }

 private:
  struct Level {
    std::vector<Index> aggregate;  ///< aggregate of each row; none: only the smoother treats it
    CoarseMatrix coarse;           ///< matrix of the next level
    ScalarArray b, x;              ///< right-hand side and solution of the next level
    ScalarArray v, d, r;
    ScalarArray left;  ///< residual after the forward sweep; then the changes by the backward sweep
  };
  /// Adds a level below m. The new level's matrix becomes `next`, which may be m itself. Returns false, with `next`
  /// unchanged, if the new level would hardly be smaller.
  template <class Matrix>
  bool add_level(const Matrix& m, WholeMatrix& next);
  template <class Matrix>
  void invert(const Matrix& m);
  template <class Matrix>
  void cycle(const Matrix& m, std::size_t level, std::span<const double> b, std::span<double> x,
             std::span<double> left);
  void correct(std::size_t level);

  const PairMatrix& finest_;
  ScalarArray left_;  ///< of the finest level; see Level::left
  std::vector<Level> levels_;
  Eigen::MatrixXd inverse_;  ///< inverse of the coarsest matrix; empty if that is too large
};

}  // namespace poretwin
