#include "fluid_solver/multigrid.hpp"

#include <algorithm>

namespace poretwin::fluid {
namespace {

/// Rows that outweigh their neighbours by this much (fixed pressures) need no coarse correction.
constexpr double dominance = 5.0;
/// Pairs are made of neighbours at least this strong, of a row's strongest.
constexpr double strong = 0.25;
constexpr std::size_t coarsest = 40;
/// A coarse solution this good is not improved by a second step.
constexpr double good_enough = 0.25;

}  // namespace

/// Each row with the strongest free neighbour.
template <class Matrix>
std::vector<Index> Multigrid::match(const Matrix& m, Index& count) {
  std::vector<Index> aggregate(m.size(), none);
  std::vector<bool> done(m.size(), false);
  count = 0;
  for (std::size_t a = 0; a < m.size(); ++a) {
    if (done[a]) continue;
    double sum = 0.0, strongest = 0.0;
    for (std::size_t k = m.begin(a); k < m.end(a); ++k) {
      sum += m.weight[k];
      strongest = std::max<double>(strongest, m.weight[k]);
    }
    done[a] = true;
    if (m.diagonal[a] >= dominance * sum) continue;
    Index partner = none;
    double best = strong * strongest;
    for (std::size_t k = m.begin(a); k < m.end(a); ++k) {
      const Index b = m.column(a, k);
      if (done[b] || b == a || m.weight[k] < best) continue;
      best = m.weight[k];
      partner = b;
    }
    aggregate[a] = count;
    if (partner != none) {
      aggregate[partner] = count;
      done[partner] = true;
    }
    ++count;
  }
  return aggregate;
}

/// Sums over aggregates; couplings to rows that have none stay in the diagonal.
template <class Matrix>
Multigrid::CoarseMatrix Multigrid::coarsen(const Matrix& m, const std::vector<Index>& aggregate, std::size_t count) {
  std::vector<Index> first(count + 1, 0), rows(m.size());
  for (const Index g : aggregate)
    if (g != none) ++first[g + 1];
  for (std::size_t g = 0; g < count; ++g) first[g + 1] += first[g];
  std::vector<Index> next(first.begin(), first.end() - 1);
  for (std::size_t a = 0; a < m.size(); ++a)
    if (aggregate[a] != none) rows[next[aggregate[a]]++] = static_cast<Index>(a);
  CoarseMatrix c;
  c.diagonal.assign(count, 0.0);
  c.column.offset.reserve(count + 1);
  c.column.index.reserve(m.weight.size() / 2);
  c.weight.reserve(m.weight.size() / 2);
  std::vector<Index> place(count, none);
  for (std::size_t g = 0; g < count; ++g) {
    const std::size_t begin = c.weight.size();
    for (Index i = first[g]; i < first[g + 1]; ++i) {
      const Index a = rows[i];
      c.diagonal[g] += m.diagonal[a];
      for (std::size_t k = m.begin(a); k < m.end(a); ++k) {
        const Index other = aggregate[m.column(a, k)];
        if (other == none) continue;
        if (other == g) {
          c.diagonal[g] -= m.weight[k];
          continue;
        }
        if (place[other] == none || place[other] < begin) {
          place[other] = static_cast<Index>(c.weight.size());
          c.column.index.push_back(other);
          c.weight.push_back(m.weight[k]);
        } else {
          c.weight[place[other]] += m.weight[k];
        }
      }
    }
    c.column.offset.push_back(static_cast<Index>(c.weight.size()));
  }
  return c;
}

template <class Matrix>
bool Multigrid::add_level(const Matrix& m) {
  // Pairs of pairs.
  Index pairs = 0, count = 0;
  std::vector<Index> aggregate = match(m, pairs);
  const CoarseMatrix half = coarsen(m, aggregate, pairs);
  const std::vector<Index> again = match(half, count);
  if (count == 0 || 4 * count > 3 * m.size()) return false;
  for (Index& g : aggregate)
    if (g != none) g = again[g];
  Level level;
  level.coarse = coarsen(half, again, count);
  level.aggregate = std::move(aggregate);
  level.residual.resize(m.size());
  for (auto* work : {&level.b, &level.x, &level.v, &level.w, &level.d, &level.r}) work->resize(count);
  levels_.push_back(std::move(level));
  return true;
}

/// A closed domain leaves the mean undetermined: inverted where the matrix acts.
template <class Matrix>
void Multigrid::invert(const Matrix& m) {
  if (m.size() > 10 * coarsest) return;
  const auto n = static_cast<Eigen::Index>(m.size());
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t a = 0; a < m.size(); ++a) {
    const auto i = static_cast<Eigen::Index>(a);
    dense(i, i) += m.diagonal[a];
    for (std::size_t k = m.begin(a); k < m.end(a); ++k)
      dense(i, static_cast<Eigen::Index>(m.column(a, k))) -= m.weight[k];
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(dense);
  const double least = 1e-12 * eigen.eigenvalues().cwiseAbs().maxCoeff();
  const Eigen::VectorXd inverse = (eigen.eigenvalues().array() > least).select(eigen.eigenvalues().cwiseInverse(), 0.0);
  inverse_ = eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
}

Multigrid::Multigrid(const PairMatrix& matrix) : finest_(matrix) {
  levels_.reserve(64);  // add_level reads from one while it adds the next
  bool coarser = matrix.size() > coarsest && add_level(matrix);
  while (coarser && levels_.back().coarse.size() > coarsest) coarser = add_level(levels_.back().coarse);
  if (levels_.empty())
    invert(finest_);
  else
    invert(levels_.back().coarse);
}

void Multigrid::cycle(std::span<const double> r, std::span<double> z) { cycle(finest_, 0, r, z); }

template <class Matrix>
void Multigrid::cycle(const Matrix& m, std::size_t level, std::span<const double> b, std::span<double> x) {
  const auto relax = [&](std::size_t a) {
    double sum = b[a];
    for (std::size_t k = m.begin(a); k < m.end(a); ++k) sum += m.weight[k] * x[m.column(a, k)];
    if (m.diagonal[a] > 0.0) x[a] = sum / m.diagonal[a];
  };
  if (level == levels_.size()) {
    if (inverse_.size() > 0) {
      Eigen::Map<Eigen::VectorXd>(x.data(), inverse_.rows()).noalias() =
          inverse_ * Eigen::Map<const Eigen::VectorXd>(b.data(), inverse_.rows());
      return;
    }
    std::fill(x.begin(), x.end(), 0.0);
    for (std::size_t a = 0; a < m.size(); ++a) relax(a);
    for (std::size_t a = m.size(); a-- > 0;) relax(a);
    return;
  }
  Level& l = levels_[level];
  std::fill(x.begin(), x.end(), 0.0);
  for (std::size_t a = 0; a < m.size(); ++a) relax(a);
  m.apply(std::span<const double>(x.data(), x.size()), std::span<double>(l.residual));
  std::fill(l.b.begin(), l.b.end(), 0.0);
  for (std::size_t a = 0; a < m.size(); ++a)
    if (l.aggregate[a] != none) l.b[l.aggregate[a]] += b[a] - l.residual[a];
  correct(level);
  for (std::size_t a = 0; a < m.size(); ++a)
    if (l.aggregate[a] != none) x[a] += l.x[l.aggregate[a]];
  for (std::size_t a = m.size(); a-- > 0;) relax(a);
}

/// l.x from l.b on the next level: one step of conjugate gradients around its cycle, a second where that is not enough.
void Multigrid::correct(std::size_t level) {
  Level& l = levels_[level];
  if (level + 1 == levels_.size()) return cycle(l.coarse, level + 1, l.b, l.x);
  const auto multiply = [&](const ScalarArray& from, ScalarArray& to) {
    l.coarse.apply(std::span<const double>(from), std::span<double>(to));
  };
  const std::size_t n = l.b.size();
  cycle(l.coarse, level + 1, l.b, l.x);
  multiply(l.x, l.v);
  const double rho = dot(l.x, l.v), alpha = dot(l.x, l.b);
  if (!(rho > 0.0)) return;
  for (std::size_t i = 0; i < n; ++i) l.r[i] = l.b[i] - alpha / rho * l.v[i];
  if (norm(l.r) <= good_enough * norm(l.b)) {
    for (double& x : l.x) x *= alpha / rho;
    return;
  }
  cycle(l.coarse, level + 1, l.r, l.d);
  multiply(l.d, l.w);
  const double gamma = dot(l.d, l.v), second = dot(l.d, l.w) - gamma * gamma / rho, beta = dot(l.d, l.r);
  const double share = second > 0.0 ? beta / second : 0.0;
  for (std::size_t i = 0; i < n; ++i) l.x[i] = (alpha - gamma * share) / rho * l.x[i] + share * l.d[i];
}

}  // namespace poretwin::fluid
