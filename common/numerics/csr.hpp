// Sparse rows and iterative solvers that allocate no memory inside their iterations.
#pragma once

#include "common/core/in_lanes.hpp"
#include "common/core/unset.hpp"
#include "common/core/vector.hpp"
#include "common/particles/domain.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

namespace poretwin {

/// Columns of a sparse matrix, taken from the pair lists of the particles, which must outlive this object. The first
/// points have columns: the rows, and behind them the copies of other ranks' particles. The column of an image is that
/// of its parent. If the parent has no column either, it is the row's own column.
struct PairColumns {
  std::span<const Index> offset, index, parent;  ///< [rows + 1], [pairs], [points]
  std::span<const char> beyond;  ///< [rows] whether a row has points without a column of their own; empty: none has
  std::size_t count = 0;         ///< number of columns; 0: as many as rows
  [[nodiscard]] Index operator()(std::size_t a, std::size_t k) const {
    const Index j = index[k];
    const std::size_t n = count > 0 ? count : offset.size() - 1;
    if (j < n) return j;
    return parent[j] < n ? parent[j] : static_cast<Index>(a);
  }
  /// Whether the columns of row a can be read from `index` directly.
  [[nodiscard]] bool direct(std::size_t a) const { return beyond.empty() || beyond[a] == 0; }
};

/// Matrix of a graph Laplacian on pairs of particles, plus a diagonal: (A x)_a = diagonal_a x_a - sum_k weight_k
/// x_column(k), symmetric by construction. Rows are padded to multiples of four with weights of zero. Weights are
/// rounded to single precision, equally for both rows of a pair. The diagonal is the sum of the rounded weights, so
/// that the Laplacian of a constant is exactly zero.
struct PairMatrix {
  PairColumns column;
  UnsetArray<float> weight;  ///< per entry, >= 0
  ScalarArray diagonal;      ///< per row
  [[nodiscard]] std::size_t size() const { return diagonal.size(); }
  [[nodiscard]] std::size_t begin(std::size_t a) const { return column.offset[a]; }
  [[nodiscard]] std::size_t end(std::size_t a) const { return column.offset[a + 1]; }
  /// Sum of weight_k x_column(k) over row a.
  [[nodiscard, gnu::always_inline]] double off_diagonal_sum(std::size_t a, const double* x) const {
    std::array<double, n_lanes> sum{};
    const Index* const index = column.index.data();
    const float* const w = weight.data();
    const std::size_t stop = end(a);
    if (column.direct(a)) {
      for (std::size_t k = begin(a); k < stop; k += n_lanes)
        for (std::size_t l = 0; l < n_lanes; ++l) sum[l] += static_cast<double>(w[k + l]) * x[index[k + l]];
    } else {
      for (std::size_t k = begin(a); k < stop; k += n_lanes)
        for (std::size_t l = 0; l < n_lanes; ++l) sum[l] += static_cast<double>(w[k + l]) * x[column(a, k + l)];
    }
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
  }
  /// Sum of row a over its columns and the diagonal, as apply() gives it for a constant of 1.
  [[nodiscard]] double row_sum(std::size_t a) const {
    std::array<double, n_lanes> sum{};
    for (std::size_t k = begin(a); k < end(a); k += n_lanes)
      for (std::size_t l = 0; l < n_lanes; ++l) sum[l] += static_cast<double>(weight[k + l]);
    return diagonal[a] - ((sum[0] + sum[1]) + (sum[2] + sum[3]));
  }
  /// y = A x, where x also has the entries of the copies
  void apply(std::span<const double> x, std::span<double> y) const {
    for_each_in_lanes(
        size(), [&](std::size_t a)
                    __attribute__((always_inline)) { y[a] = diagonal[a] * x[a] - off_diagonal_sum(a, x.data()); });
  }
};

struct SolveReport {
  int iterations = 0;
  bool converged = true;
  double residual = 0.0;  ///< norm of b - A x of the result; only from conjugate_gradients()
};

/// Preconditioned conjugate gradients, matrix-free. Vectors contain the rows that this rank owns. apply(x, y): y = A x,
/// where x also contains the halo's entries, up to date. precondition(r, z): z = P^-1 r. P may change slightly between
/// steps, since each direction is made conjugate to the last (flexible; Notay 2000), and may leave out contributions of
/// other ranks. r: the residual b - A x of the given x. Stops when |residual| <= tolerance (absolute), or when residual
/// . z <= `energy`; residual . z is of the order of the error's energy.
template <class Apply, class Precondition>
SolveReport reduce_residual(const Domain& domain, Apply&& apply, Precondition&& precondition, ScalarArray r,
                            std::span<double> x, double tolerance, int limit, double energy = 0.0) {
  const std::size_t n = r.size();
  SolveReport report;
  if (domain.norm(r) <= tolerance) return report;
  ScalarArray z(n), p, q(n);
  precondition(std::span<const double>(r), std::span<double>(z));
  p = z;
  p.resize(domain.with_halo(n));
  double rz = domain.dot(r, z);
  if (rz <= energy) return report;
  for (; report.iterations < limit;) {
    domain.exchange(p, domain.each(n));
    apply(std::span<const double>(p), std::span<double>(q));
    ++report.iterations;
    const double pq = domain.dot(std::span(p).first(n), q);
    if (!(pq > 0.0)) break;
    const double alpha = rz / pq;
    parallel_for(n, [&](std::size_t i) {
      x[i] += alpha * p[i];
      r[i] -= alpha * q[i];
    });
    if (domain.norm(r) <= tolerance) return report;
    precondition(std::span<const double>(r), std::span<double>(z));
    const double beta = -domain.dot(z, q) / pq;
    rz = domain.dot(r, z);
    if (rz <= energy) return report;
    parallel_for(n, [&](std::size_t i) { p[i] = z[i] + beta * p[i]; });
  }
  report.converged = false;
  return report;
}

/// Conjugate gradients for A x = b, starting from the given x. The residual that the iteration carries along is that of
/// x only if A is symmetric, and then up to rounding. So the residual of x itself decides at the end. If it does not
/// meet the tolerance, the iteration begins anew from x, as long as that halves the residual.
template <class Apply, class Precondition>
SolveReport conjugate_gradients(const Domain& domain, Apply&& apply, Precondition&& precondition,
                                std::span<const double> b, std::span<double> x, double tolerance, int limit) {
  const std::size_t n = b.size();
  SolveReport report;
  for (double before = std::numeric_limits<double>::infinity();;) {
    ScalarArray residual(n), at(x.begin(), x.end());
    at.resize(domain.with_halo(n));
    domain.exchange(at, domain.each(n));
    apply(std::span<const double>(at), std::span<double>(residual));
    parallel_for(n, [&](std::size_t i) { residual[i] = b[i] - residual[i]; });
    report.residual = domain.norm(residual);
    report.converged = report.residual <= tolerance;
    if (report.converged || !(report.residual <= 0.5 * before) || report.iterations >= limit) return report;
    before = report.residual;
    report.iterations +=
        reduce_residual(domain, apply, precondition, std::move(residual), x, tolerance, limit - report.iterations)
            .iterations;
  }
}

struct GmresReport : SolveReport {
  Eigen::VectorXd shares;  ///< coefficient in x of each direction that was applied, in their order
};

/// Flexible GMRES (Saad 1993) without restart, from x = 0. The preconditioner may itself be an iteration. Vectors and
/// functions are as for reduce_residual.
template <class Apply, class Precondition>
GmresReport flexible_gmres(const Domain& domain, Apply&& apply, Precondition&& precondition, std::span<const double> b,
                           std::span<double> x, double tolerance, int limit) {
  const std::size_t n = b.size();
  std::fill(x.begin(), x.end(), 0.0);
  GmresReport report;
  const double beta = domain.norm(b);
  if (beta <= tolerance || beta == 0.0) return report;
  const auto m = static_cast<std::size_t>(limit);
  std::vector<ScalarArray> v{ScalarArray(b.begin(), b.end())}, z;
  for (auto& e : v[0]) e /= beta;
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(limit + 1, limit);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(limit + 1), cosine(limit), sine(limit);
  g[0] = beta;
  int k = 0;
  for (std::size_t j = 0; j < m; ++j) {
    z.emplace_back(domain.with_halo(n), 0.0);
    precondition(std::span<const double>(v[j]), std::span<double>(z[j]).first(n));
    domain.exchange(z[j], domain.each(n));
    ScalarArray w(n);
    apply(std::span<const double>(z[j]), std::span<double>(w));
    const auto c = static_cast<Eigen::Index>(j);
    for (std::size_t i = 0; i <= j; ++i) {
      const double projection = domain.dot(w, v[i]);
      h(static_cast<Eigen::Index>(i), c) = projection;
      for (std::size_t e = 0; e < n; ++e) w[e] -= projection * v[i][e];
    }
    const double length = domain.norm(w);
    h(c + 1, c) = length;
    for (Eigen::Index i = 0; i < c; ++i) {
      const double t = cosine[i] * h(i, c) + sine[i] * h(i + 1, c);
      h(i + 1, c) = -sine[i] * h(i, c) + cosine[i] * h(i + 1, c);
      h(i, c) = t;
    }
    const double radius = std::hypot(h(c, c), h(c + 1, c));
    if (!(radius > 0.0)) break;
    cosine[c] = h(c, c) / radius;
    sine[c] = h(c + 1, c) / radius;
    h(c, c) = radius;
    h(c + 1, c) = 0.0;
    g[c + 1] = -sine[c] * g[c];
    g[c] *= cosine[c];
    ++report.iterations;
    k = report.iterations;
    if (std::abs(g[c + 1]) <= tolerance || length == 0.0) break;
    if (j + 1 == m) {
      report.converged = false;
      break;
    }
    for (auto& e : w) e /= length;
    v.push_back(std::move(w));
  }
  report.shares = h.topLeftCorner(k, k).template triangularView<Eigen::Upper>().solve(g.head(k));
  for (int j = 0; j < k; ++j)
    for (std::size_t e = 0; e < n; ++e) x[e] += report.shares[j] * z[static_cast<std::size_t>(j)][e];
  return report;
}

}  // namespace poretwin
