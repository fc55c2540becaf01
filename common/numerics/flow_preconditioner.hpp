// Preconditioner for matrices of flows between points. They are unsymmetric where water flows with gravity.
#pragma once

#include "common/numerics/ilu0.hpp"
#include "common/numerics/multigrid.hpp"

#include <algorithm>
#include <optional>
#include <span>

namespace poretwin {

/// The part of a flow matrix A that multigrid can treat: diffusion and storage. With x = scale * y, where y are changes
/// of heads, the matrix for y is A~ = A diag(scale). The weight between two rows is the mean of A~'s two entries; the
/// diagonal is the sum of the weights and of A~'s column, which is what a point stores or passes through the border.
/// Weights and diagonal are not negative, so that this part is symmetric and positive.
class DiffusivePart {
 public:
  /// The sparsity of `matrix` is symmetric.
  DiffusivePart(const SparseRows& matrix, std::span<const double> scale) {
    const std::size_t n = matrix.size();
    ScalarArray column_sum(n, 0.0);
    for (std::size_t a = 0; a < n; ++a)
      for (Index k = matrix.begin(a); k < matrix.end(a); ++k) column_sum[matrix.column(k)] += matrix[k];
    for (std::size_t a = 0; a < n; ++a) {
      const auto row = static_cast<Index>(a);
      double sum = 0.0;
      const auto put = [&](Index column, double weight) {
        index_.push_back(column);
        part_.weight.push_back(static_cast<float>(weight));
        sum += static_cast<double>(part_.weight.back());
      };
      for (Index k = matrix.begin(a); k < matrix.end(a); ++k) {
        const Index b = matrix.column(k);
        if (b != row) put(b, std::max(0.0, -0.5 * (matrix[k] * scale[b] + matrix[matrix.place(b, row)] * scale[a])));
      }
      while (index_.size() % n_lanes != 0) put(row, 0.0);
      offset_.push_back(static_cast<Index>(index_.size()));
      part_.diagonal.push_back(sum + std::max(0.0, column_sum[a] * scale[a]));
    }
    part_.column = {offset_, index_, {}, {}};
  }
  DiffusivePart(const DiffusivePart&) = delete;
  DiffusivePart& operator=(const DiffusivePart&) = delete;
  [[nodiscard]] const PairMatrix& matrix() const { return part_; }

 private:
  std::vector<Index> offset_{0}, index_;
  PairMatrix part_;
};

/// Incomplete factors, which are accurate for transport and for short distances. A solve that is not done after some
/// iterations with them goes on with a cycle of multigrid after each, for the smooth changes of heads that they leave;
/// then the number of iterations does not grow with the number of points.
class FlowPreconditioner {
 public:
  /// scale: for each column, the change of its unknown with its head. alone: number of iterations by incomplete factors
  /// alone. The matrix and `scale` must outlive this object.
  FlowPreconditioner(const SparseRows& matrix, std::span<const double> scale, int alone)
      : matrix_(matrix), scale_(scale), alone_(alone), factors_(matrix) {}
  FlowPreconditioner(const FlowPreconditioner&) = delete;
  FlowPreconditioner& operator=(const FlowPreconditioner&) = delete;

  /// z = P^-1 r. P changes between iterations, and needs flexible_gmres().
  void apply(std::span<const double> r, std::span<double> z) {
    factors_.apply(r, z);
    if (alone_-- > 0) return;
    const std::size_t n = r.size();
    if (!multigrid_) {
      multigrid_.emplace(diffusive_.emplace(matrix_, scale_).matrix());
      left_.resize(n);
      heads_.resize(n);
    }
    matrix_.apply(z, left_);
    for (std::size_t a = 0; a < n; ++a) left_[a] = r[a] - left_[a];
    multigrid_->cycle(left_, heads_);
    for (std::size_t a = 0; a < n; ++a) z[a] += scale_[a] * heads_[a];
  }

 private:
  const SparseRows& matrix_;
  std::span<const double> scale_;
  int alone_;
  Ilu0 factors_;
  std::optional<DiffusivePart> diffusive_;
  std::optional<Multigrid> multigrid_;
  ScalarArray left_, heads_;
};

}  // namespace poretwin
