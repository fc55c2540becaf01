#include "common/numerics/multigrid.hpp"

#include <algorithm>

namespace poretwin {
namespace {

/// Rows (of fixed pressures) with a diagonal above this factor times the sum of weights need no coarse correction.
constexpr double dominance = 5.0;
/// Least weight between a row and a neighbour with which it may be paired, over the row's largest weight.
constexpr double strong = 0.25;
constexpr std::size_t coarsest = 40;
constexpr Index none = static_cast<Index>(-1);
/// Residual over right-hand side at which a coarse solution is accepted without a second step.
constexpr double good_enough = 0.25;

/// Visits the rows of a matrix by visit(a, take_diagonal, take_entry).
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

/// A matrix whose rows are sums over aggregates. Each row is computed when it is visited, and not stored: the matrix of
/// pairs, an intermediate step to aggregates of four, would be the largest of all. Couplings to rows without an
/// aggregate remain in the diagonal.
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
  std::vector<Index> first_, members_;  ///< rows of aggregate g: members_[first_[g]] to members_[first_[g + 1] - 1]
  std::vector<Index> place_;            ///< position of each column in the present row
  std::vector<Index> column_;           ///< columns of the present row, in the order of its weights
  ScalarArray weight_;
};

/// Pairs each row with its strongest neighbour that is not yet in a pair; returns the aggregate of each row.
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
WholeMatrix matrix_of(Rows& rows) {
  WholeMatrix c;
  c.diagonal.reserve(rows.size());
  c.offset.reserve(rows.size() + 1);
  for (std::size_t g = 0; g < rows.size(); ++g) {
    rows.visit(
        g, [&](double diagonal) { c.diagonal.push_back(diagonal); },
        [&](Index column, double weight) {
          c.index.push_back(column);
          c.weight.push_back(weight);
        });
    c.offset.push_back(static_cast<Index>(c.weight.size()));
  }
  return c;
}

/// Gauss-Seidel sweep forwards from x = 0. `left`: the residual b - A x.
void sweep_forwards(const PairMatrix& m, std::span<const double> b, std::span<double> x, std::span<double> left) {
  std::fill(x.begin(), x.end(), 0.0);
  for (std::size_t a = 0; a < m.size(); ++a)
    if (m.diagonal[a] > 0.0) x[a] = (b[a] + m.off_diagonal_sum(a, x.data())) / m.diagonal[a];
  m.apply(x, left);
  for (std::size_t a = 0; a < m.size(); ++a) left[a] = b[a] - left[a];
}

/// Gauss-Seidel sweep forwards from x = 0. `left`: the residual b - A x. Each row is solved with the x of the rows
/// before it. The x of later rows is still 0, so that the residual consists of their contributions alone.
void sweep_forwards(const CoarseMatrix& m, std::span<const double> b, std::span<double> x, std::span<double> left) {
  for (std::size_t a = 0; a < m.size(); ++a) {
    x[a] = m.diagonal(a) > 0.0 ? (b[a] + m.off_diagonal_sum(a, x.data())) / m.diagonal(a) : 0.0;
    left[a] = 0.0;
    m.push(a, x[a], left.data());
  }
}

/// Gauss-Seidel sweep backwards from x.
void sweep_backwards(const PairMatrix& m, std::span<const double> b, std::span<double> x, std::span<double>) {
  for (std::size_t a = m.size(); a-- > 0;)
    if (m.diagonal[a] > 0.0) x[a] = (b[a] + m.off_diagonal_sum(a, x.data())) / m.diagonal[a];
}

/// Gauss-Seidel sweep backwards from x. `left`: the change of x. Until the sweep reaches a row, the row's element of
/// `left` collects the contributions of the changes in later rows to its balance.
void sweep_backwards(const CoarseMatrix& m, std::span<const double> b, std::span<double> x, std::span<double> left) {
  std::fill(left.begin(), left.end(), 0.0);
  for (std::size_t a = m.size(); a-- > 0;) {
    const double before = x[a];
    if (m.diagonal(a) > 0.0) x[a] = (b[a] + left[a] + m.off_diagonal_sum(a, x.data())) / m.diagonal(a);
    left[a] = x[a] - before;
    m.push(a, x[a], left.data());
  }
}

}  // namespace

CoarseMatrix::CoarseMatrix(const WholeMatrix& whole) : diagonal_(whole.diagonal) {
  const auto put = [&](Index column, float weight) {
    column_.push_back(column);
    weight_.push_back(weight);
  };
  offset_.reserve(whole.size() + 1);
  for (std::size_t a = 0; a < whole.size(); ++a) {
    for (std::size_t k = whole.begin(a); k < whole.end(a); ++k) {
      const auto rounded = static_cast<float>(whole.weight[k]);
      diagonal_[a] += static_cast<double>(rounded) - whole.weight[k];
      if (whole.column(a, k) < a) put(whole.column(a, k), rounded);
    }
    while (column_.size() % in_step != 0) put(static_cast<Index>(a), 0.0F);
    offset_.push_back(static_cast<Index>(column_.size()));
  }
  column_.shrink_to_fit();
  weight_.shrink_to_fit();
}

template <class Matrix>
bool Multigrid::add_level(const Matrix& m, WholeMatrix& next) {
  // Pairing the pairs once more gives aggregates of four.
  Index n_pairs = 0, count = 0;
  RowsOf<Matrix> rows{m};
  std::vector<Index> aggregate = match(rows, n_pairs);
  {
    MergedRows pairs(rows, aggregate, n_pairs);
    const std::vector<Index> again = match(pairs, count);
    if (count == 0 || 4 * count > 3 * m.size()) return false;
    MergedRows fours(pairs, again, count);
    next = matrix_of(fours);
    for (Index& g : aggregate)
      if (g != none) g = again[g];
  }
  levels_.emplace_back().aggregate = std::move(aggregate);
  levels_.back().coarse = CoarseMatrix(next);
  return true;
}

/// Inverts the coarsest matrix; in a closed domain, where the mean is undetermined, only on the range of the matrix.
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

Multigrid::Multigrid(const PairMatrix& matrix) : finest_(matrix), left_(matrix.size()) {
  WholeMatrix coarse;
  bool coarser = matrix.size() > coarsest && add_level(matrix, coarse);
  while (coarser && coarse.size() > coarsest) coarser = add_level(coarse, coarse);
  if (levels_.empty())
    invert(finest_);
  else
    invert(coarse);
  coarse = {};
  for (Level& l : levels_)
    for (auto* work : {&l.b, &l.x, &l.v, &l.d, &l.r, &l.left}) work->resize(l.coarse.size());
}

void Multigrid::cycle(std::span<const double> r, std::span<double> z) { cycle(finest_, 0, r, z, left_); }

template <class Matrix>
void Multigrid::cycle(const Matrix& m, std::size_t level, std::span<const double> b, std::span<double> x,
                      std::span<double> left) {
  if (level == levels_.size() && inverse_.size() > 0) {
    Eigen::Map<Eigen::VectorXd>(x.data(), inverse_.rows()).noalias() =
        inverse_ * Eigen::Map<const Eigen::VectorXd>(b.data(), inverse_.rows());
    return;
  }
  sweep_forwards(m, b, x, left);
  if (level < levels_.size()) {
    Level& l = levels_[level];
    std::fill(l.b.begin(), l.b.end(), 0.0);
    for (std::size_t a = 0; a < m.size(); ++a)
      if (l.aggregate[a] != none) l.b[l.aggregate[a]] += left[a];
    correct(level);
    for (std::size_t a = 0; a < m.size(); ++a)
      if (l.aggregate[a] != none) x[a] += l.x[l.aggregate[a]];
  }
  sweep_backwards(m, b, x, left);
}

/// Computes l.x from l.b on the next level: one step of conjugate gradients, preconditioned by the cycle of that level,
/// and a second step where one does not suffice.
void Multigrid::correct(std::size_t level) {
  Level& l = levels_[level];
  const CoarseMatrix& m = l.coarse;
  cycle(m, level + 1, l.b, l.x, l.left);
  if (level + 1 == levels_.size()) return;
  // A x of the x that the last cycle computed from b: its backward sweep solved row a exactly and then changed the x of
  // the rows before it by l.left.
  const auto product = [&](std::size_t a, double b) {
    return m.diagonal(a) > 0.0 ? b - m.off_diagonal_sum(a, l.left.data()) : 0.0;
  };
  const std::size_t n = m.size();
  double rho = 0.0, alpha = 0.0, before = 0.0, after = 0.0;
  for (std::size_t a = 0; a < n; ++a) {
    l.v[a] = product(a, l.b[a]);
    rho += l.x[a] * l.v[a];
    alpha += l.x[a] * l.b[a];
    before += l.b[a] * l.b[a];
  }
  if (!(rho > 0.0)) return;
  for (std::size_t a = 0; a < n; ++a) {
    l.r[a] = l.b[a] - alpha / rho * l.v[a];
    after += l.r[a] * l.r[a];
  }
  if (after <= good_enough * good_enough * before) {
    for (double& x : l.x) x *= alpha / rho;
    return;
  }
  cycle(m, level + 1, l.r, l.d, l.left);
  double gamma = 0.0, beta = 0.0, energy = 0.0;
  for (std::size_t a = 0; a < n; ++a) {
    gamma += l.d[a] * l.v[a];
    beta += l.d[a] * l.r[a];
    energy += l.d[a] * product(a, l.r[a]);
  }
  const double second = energy - gamma * gamma / rho, share = second > 0.0 ? beta / second : 0.0;
  for (std::size_t a = 0; a < n; ++a) l.x[a] = (alpha - gamma * share) / rho * l.x[a] + share * l.d[a];
}

}  // namespace poretwin
