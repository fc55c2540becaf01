// Sparse rows of unsymmetric matrices, and their incomplete factors as a preconditioner.
#pragma once

#include "common/core/vector.hpp"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

namespace poretwin {

/// Rows of a matrix. Each row has its columns in increasing order, including the diagonal.
class SparseRows {
 public:
  SparseRows() = default;
  /// The matrix of n rows with off-diagonal entries at these (row, column) places. They are given in any order,
  /// and may be given more than once. All values are zero.
  SparseRows(std::size_t n, std::vector<std::pair<Index, Index>> places) {
    for (std::size_t a = 0; a < n; ++a) places.emplace_back(static_cast<Index>(a), static_cast<Index>(a));
    std::sort(places.begin(), places.end());
    places.erase(std::unique(places.begin(), places.end()), places.end());
    offset_.assign(n + 1, 0);
    for (const auto& [row, column] : places) {
      ++offset_[row + 1];
      if (row == column) diagonal_.push_back(static_cast<Index>(column_.size()));
      column_.push_back(column);
    }
    for (std::size_t a = 0; a < n; ++a) offset_[a + 1] += offset_[a];
    value_.assign(column_.size(), 0.0);
  }

  [[nodiscard]] std::size_t size() const { return diagonal_.size(); }
  [[nodiscard]] Index begin(std::size_t row) const { return offset_[row]; }
  [[nodiscard]] Index end(std::size_t row) const { return offset_[row + 1]; }
  [[nodiscard]] Index diagonal(std::size_t row) const { return diagonal_[row]; }  ///< place of the diagonal entry
  [[nodiscard]] Index column(Index place) const { return column_[place]; }
  [[nodiscard]] double& operator[](Index place) { return value_[place]; }
  [[nodiscard]] double operator[](Index place) const { return value_[place]; }
  /// The place of an entry that exists.
  [[nodiscard]] Index place(std::size_t row, Index column) const {
    return static_cast<Index>(
        std::lower_bound(column_.begin() + offset_[row], column_.begin() + offset_[row + 1], column) - column_.begin());
  }
  void clear() { std::fill(value_.begin(), value_.end(), 0.0); }

  /// y = A x
  void apply(std::span<const double> x, std::span<double> y) const {
    for (std::size_t a = 0; a < size(); ++a) {
      double sum = 0.0;
      for (Index k = offset_[a]; k < offset_[a + 1]; ++k) sum += value_[k] * x[column_[k]];
      y[a] = sum;
    }
  }

 private:
  std::vector<Index> offset_{0}, column_, diagonal_;
  ScalarArray value_;
};

/// Incomplete triangular factors with the sparsity of the matrix (Meijerink & van der Vorst 1977). They exist for an
/// M-matrix, such as that of fluxes with upstream conductivities. For a tridiagonal matrix they are exact.
class Ilu0 {
 public:
  explicit Ilu0(const SparseRows& matrix) : factors_(matrix) {
    const std::size_t n = factors_.size();
    constexpr Index none = static_cast<Index>(-1);
    std::vector<Index> place(n, none);  // places of the present row's columns
    for (std::size_t a = 0; a < n; ++a) {
      for (Index k = factors_.begin(a); k < factors_.end(a); ++k) place[factors_.column(k)] = k;
      for (Index k = factors_.begin(a); k < factors_.diagonal(a); ++k) {
        const Index row = factors_.column(k);
        factors_[k] *= inverse_[row];
        for (Index l = factors_.diagonal(row) + 1; l < factors_.end(row); ++l)
          if (const Index at = place[factors_.column(l)]; at != none) factors_[at] -= factors_[k] * factors_[l];
      }
      for (Index k = factors_.begin(a); k < factors_.end(a); ++k) place[factors_.column(k)] = none;
      inverse_.push_back(1.0 / factors_[factors_.diagonal(a)]);
    }
  }
  /// z = (L U)^-1 r
  void apply(std::span<const double> r, std::span<double> z) const {
    const std::size_t n = factors_.size();
    for (std::size_t a = 0; a < n; ++a) {
      double sum = r[a];
      for (Index k = factors_.begin(a); k < factors_.diagonal(a); ++k) sum -= factors_[k] * z[factors_.column(k)];
      z[a] = sum;
    }
    for (std::size_t a = n; a-- > 0;) {
      double sum = z[a];
      for (Index k = factors_.diagonal(a) + 1; k < factors_.end(a); ++k) sum -= factors_[k] * z[factors_.column(k)];
      z[a] = sum * inverse_[a];
    }
  }

 private:
  SparseRows factors_;
  ScalarArray inverse_;  ///< inverse of the diagonal of U
};

}  // namespace poretwin
