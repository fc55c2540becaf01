#include "fluid_solver/multigrid.hpp"

#include <algorithm>

namespace poretwin::fluid {
namespace {

/// Rows that outweigh their neighbours by this much (fixed pressures) need no coarse correction.
constexpr double dominance = 5.0;
/// Pairs are made of neighbours at least this strong, of a row's strongest.
constexpr double strong = 0.25;
constexpr std::size_t coarsest = 40;
constexpr Index none = static_cast<Index>(-1);
/// A coarse solution this good is not improved by a second step.
constexpr double good_enough = 0.25;

/// A matrix, row by row: visit(a, take_diagonal, take_entry).
template <class Matrix>
struct RowsOf {
  const Matrix& m;
  [[nodiscard]] std::size_t size() const { return m.size(); }
  template <class TakeDiagonal, class TakeEntry>
  void visit(std::size_t a, const TakeDiagonal& take_diagonal, const TakeEntry& take_entry) {
    take_diagonal(m.diagonal[a]);
    for (std::size_t k = m.begin(a); k < m.end(a); ++k) take_entry(m.column(a, k), static_cast<double>(m.weight[k]));
  }
};

/// The sums of rows over aggregates, each made when it is visited: the matrix of pairs, on the way to pairs of pairs,
/// would be the largest of all. Couplings to rows that have no aggregate stay in the diagonal.
template <class Fine>
class MergedRows {
 public:
  MergedRows(Fine& fine, const std::vector<Index>& aggregate, std::size_t count)
      : fine_(fine), aggregate_(aggregate), first_(count + 1, 0), members_(fine.size()), place_(count, none) {
    for (const Index g : aggregate)
      if (g != none) ++first_[g + 1];
    for (std::size_t g = 0; g < count; ++g) first_[g + 1] += first_[g];
    std::vector<Index> next(first_.begin(), first_.end() - 1);
    for (std::size_t a = 0; a < fine.size(); ++a)
      if (aggregate[a] != none) members_[next[aggregate[a]]++] = static_cast<Index>(a);
  }
  [[nodiscard]] std::size_t size() const { return place_.size(); }
  template <class TakeDiagonal, class TakeEntry>
  void visit(std::size_t g, const TakeDiagonal& take_diagonal, const TakeEntry& take_entry) {
    double diagonal = 0.0;
    column_.clear();
    weight_.clear();
    for (Index i = first_[g]; i < first_[g + 1]; ++i)
      fine_.visit(
          members_[i], [&](double own) { diagonal += own; },
          [&](Index column, double weight) {
            const Index other = aggregate_[column];
            if (other == none) return;
            if (other == g) {
              diagonal -= weight;
            } else if (place_[other] == none) {
              place_[other] = static_cast<Index>(column_.size());
              column_.push_back(other);
              weight_.push_back(weight);
            } else {
              weight_[place_[other]] += weight;
            }
          });
    take_diagonal(diagonal);
    for (std::size_t k = 0; k < column_.size(); ++k) {
      place_[column_[k]] = none;
      take_entry(column_[k], weight_[k]);
    }
  }

 private:
  Fine& fine_;
  const std::vector<Index>& aggregate_;
  std::vector<Index> first_, members_;  ///< rows of each aggregate: members_[first_[g]] ..
  std::vector<Index> place_;            ///< of each column in the row at hand
  std::vector<Index> column_;           ///< of the row at hand, as its weights
  ScalarArray weight_;
};

/// Each row with the strongest free neighbour.
template <class Rows>
std::vector<Index> match(Rows& rows, Index& count) {
  std::vector<Index> aggregate(rows.size(), none), column;
  std::vector<bool> done(rows.size(), false);
  ScalarArray weight;
  count = 0;
  for (std::size_t a = 0; a < rows.size(); ++a) {
    if (done[a]) continue;
    double diagonal = 0.0, sum = 0.0, strongest = 0.0;
    column.clear();
    weight.clear();
    rows.visit(
        a, [&](double own) { diagonal = own; },
        [&](Index b, double w) {
          column.push_back(b);
          weight.push_back(w);
          sum += w;
          strongest = std::max(strongest, w);
        });
    done[a] = true;
    if (diagonal >= dominance * sum) continue;
    Index partner = none;
    double best = strong * strongest;
    for (std::size_t k = 0; k < column.size(); ++k) {
      if (done[column[k]] || column[k] == a || weight[k] < best) continue;
      best = weight[k];
      partner = column[k];
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

template <class Rows>
Multigrid::CoarseMatrix matrix_of(Rows& rows) {
  Multigrid::CoarseMatrix c;
  c.diagonal.reserve(rows.size());
  c.column.offset.reserve(rows.size() + 1);
  for (std::size_t g = 0; g < rows.size(); ++g) {
    rows.visit(
        g, [&](double diagonal) { c.diagonal.push_back(diagonal); },
        [&](Index column, double weight) {
          c.column.index.push_back(column);
          c.weight.push_back(weight);
        });
    c.column.offset.push_back(static_cast<Index>(c.weight.size()));
  }
  c.column.index.shrink_to_fit();
  c.weight.shrink_to_fit();
  return c;
}

}  // namespace

template <class Matrix>
bool Multigrid::add_level(const Matrix& m) {
  // Pairs of pairs.
  Index n_pairs = 0, count = 0;
  RowsOf<Matrix> rows{m};
  std::vector<Index> aggregate = match(rows, n_pairs);
  MergedRows pairs(rows, aggregate, n_pairs);
  const std::vector<Index> again = match(pairs, count);
  if (count == 0 || 4 * count > 3 * m.size()) return false;
  MergedRows fours(pairs, again, count);
  Level level;
  level.coarse = matrix_of(fours);
  for (Index& g : aggregate)
    if (g != none) g = again[g];
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
