// A coarse space for smooth parts of a solution. Such parts vary over many particles.
#pragma once

#include "common/core/threads.hpp"
#include "common/core/vector.hpp"

#include <Eigen/Dense>

#include <array>
#include <limits>
#include <span>

namespace poretwin {

/// Piecewise constants on square aggregates of particles. They represent the part of a solution to which a
/// preconditioner of single rows converges only slowly (two levels, additive: Nicolaides 1987).
template <int D>
class Aggregates {
 public:
  static constexpr Index none = static_cast<Index>(-1);

  /// Aggregates of side `width` [m], or larger ones if a dense matrix would have too many rows. Particles for which
  /// member(a) is false belong to no aggregate.
  template <class Member>
  Aggregates(std::span<const Vec<D>> position, double width, const Member& member) : of_(position.size(), none) {
    Vec<D> lower = Vec<D>::Constant(std::numeric_limits<double>::max()), upper = -lower;
    for (std::size_t a = 0; a < position.size(); ++a) {
      if (!member(a)) continue;
      lower = lower.cwiseMin(position[a]);
      upper = upper.cwiseMax(position[a]);
    }
    if (!(lower[0] <= upper[0])) return;
    const Vec<D> extent = upper - lower;
    std::array<std::size_t, D> count{};
    std::size_t cells = 0;
    for (;; width *= 1.2) {
      cells = 1;
      for (std::size_t d = 0; d < D; ++d) {
        count[d] = static_cast<std::size_t>(extent[static_cast<int>(d)] / width) + 1;
        cells *= count[d];
      }
      if (cells <= most) break;
    }
    std::vector<Index> number(cells, none);
    for (std::size_t a = 0; a < position.size(); ++a) {
      if (!member(a)) continue;
      std::size_t cell = 0;
      for (std::size_t d = D; d-- > 0;)
        cell = cell * count[d] +
               static_cast<std::size_t>((position[a][static_cast<int>(d)] - lower[static_cast<int>(d)]) / width);
      if (number[cell] == none) number[cell] = n_++;
      of_[a] = number[cell];
    }
    first_.assign(n_ + 1, 0);
    for (const Index i : of_)
      if (i != none) ++first_[i + 1];
    for (Index i = 0; i < n_; ++i) first_[i + 1] += first_[i];
    members_.resize(first_[n_]);
    std::vector<Index> next(first_.begin(), first_.end() - 1);
    for (std::size_t a = 0; a < of_.size(); ++a)
      if (of_[a] != none) members_[next[of_[a]]++] = static_cast<Index>(a);
  }

  [[nodiscard]] Index size() const { return n_; }
  /// The aggregate of a particle, or `none`.
  [[nodiscard]] Index of(std::size_t a) const { return of_[a]; }

  /// Assembles and factorises the coarse matrix. row(a, add) calls add(b, value) for every entry (a, b) of the fine
  /// matrix.
  template <class Row>
  void factorise(const Row& row) {
    Eigen::MatrixXd coarse = Eigen::MatrixXd::Zero(n_, n_);
    for_each_aggregate([&](Index i) {
      double own = 0.0;
      for (Index m = first_[i]; m < first_[i + 1]; ++m)
        row(static_cast<std::size_t>(members_[m]), [&](std::size_t b, double value) {
          if (of_[b] == i)
            own += value;
          else if (of_[b] != none)
            coarse(of_[b], i) += value;
        });
      coarse(i, i) = own;
    });
    factor_.compute(coarse);
    if (factor_.info() != Eigen::Success) n_ = 0;  // not finite: no correction is made; the caller's residual shows it
  }

  /// z += P A^-1 P^T r with the coarse matrix A and the prolongation P, separately for each component [particles x
  /// fields].
  template <int fields = D>
  void correct(std::span<const double> r, std::span<double> z) const {
    if (n_ == 0) return;
    Eigen::Matrix<double, Eigen::Dynamic, fields> sums =
        Eigen::Matrix<double, Eigen::Dynamic, fields>::Zero(n_, fields);
    for_each_aggregate([&](Index i) {
      for (Index m = first_[i]; m < first_[i + 1]; ++m)
        for (int d = 0; d < fields; ++d) sums(i, d) += r[members_[m] * fields + static_cast<std::size_t>(d)];
    });
    // One column at a time: triangular solves for a few columns together are slower.
    for (int d = 0; d < fields; ++d) {
      auto column = sums.col(d);
      factor_.solveInPlace(column);
    }
    for_each_aggregate([&](Index i) {
      for (Index m = first_[i]; m < first_[i + 1]; ++m)
        for (int d = 0; d < fields; ++d) z[members_[m] * fields + static_cast<std::size_t>(d)] += sums(i, d);
    });
  }

 private:
  template <class Work>
  void for_each_aggregate(const Work& work) const {
    parallel_ranges(n_, members_.size() < worth_threads ? n_ + 1 : 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) work(static_cast<Index>(i));
    });
  }

  static constexpr std::size_t most = 256;
  std::vector<Index> of_;
  std::vector<Index> first_{0}, members_;  ///< members of i begin at members_[first_[i]]
  Index n_ = 0;
  Eigen::LLT<Eigen::MatrixXd> factor_;
};

}  // namespace poretwin
