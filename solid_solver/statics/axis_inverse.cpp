#include "solid_solver/statics/axis_inverse.hpp"

#include "common/core/error.hpp"
#include "common/numerics/multigrid.hpp"
#include "solid_solver/numerics/statics.hpp"

#include <Eigen/SparseCholesky>

#include <deque>
#include <limits>

namespace poretwin::solid {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

[[noreturn]] void not_positive() {
  throw DivergedError("the soil's stiffness along an axis is not positive: report the case");
}

template <int D>
class Factors final : public AxisInverse<D> {
 public:
  void add(const Matrix& matrix) override {
    const Eigen::SimplicialLLT<Matrix> done(matrix);
    if (done.info() != Eigen::Success) not_positive();
    const Matrix lower = done.matrixL();
    if (axis_ == 0) {
      const auto& order = done.permutationP().indices();
      place_.assign(order.data(), order.data() + order.size());
      offset_.assign(1, 0);
      inverse_.resize(place_.size());
      for (Eigen::Index column = 0; column < lower.outerSize(); ++column) {
        for (Matrix::InnerIterator entry(lower, column); entry; ++entry)
          if (entry.row() > column) row_.push_back(static_cast<Index>(entry.row()));
        offset_.push_back(static_cast<Index>(row_.size()));
      }
      factor_.resize(row_.size());
    }
    std::size_t next = 0;
    for (Eigen::Index column = 0; column < lower.outerSize(); ++column)
      for (Matrix::InnerIterator entry(lower, column); entry; ++entry) {
        if (entry.row() > column)
          factor_[next++][axis_] = static_cast<float>(entry.value());
        else
          inverse_[static_cast<std::size_t>(column)][axis_] = 1.0 / entry.value();
      }
    ++axis_;
  }

  [[nodiscard]] double work(const VecArray<D>& forces) const override {
    EachAxis sum = EachAxis::Zero();
    for (const EachAxis& x : eliminated(forces)) sum += x.square();
    return sum.sum();
  }

  [[nodiscard]] VecArray<D> displacements(const VecArray<D>& forces) const override {
    const std::size_t n = forces.size();
    std::vector<EachAxis> x = eliminated(forces);
    for (std::size_t column = n; column-- > 0;) {
      const std::size_t first = offset_[column], last = offset_[column + 1], pairs = first + (last - first) / 2 * 2;
      EachAxis left = x[column], other = EachAxis::Zero();  // two sums, so that the processor can add to both at once
      for (std::size_t m = first; m < pairs; m += 2) {
        left -= factor_[m].template cast<double>() * x[row_[m]];
        other -= factor_[m + 1].template cast<double>() * x[row_[m + 1]];
      }
      if (pairs < last) left -= factor_[pairs].template cast<double>() * x[row_[pairs]];
      x[column] = (left + other) * inverse_[column];
    }
    VecArray<D> moved(n);
    for (std::size_t i = 0; i < n; ++i) moved[i] = x[place_[i]].matrix();
    return moved;
  }

 private:
  using EachAxis = Eigen::Array<double, D, 1>;
  /// L^-1 times the forces, with the factor L, in the order of elimination.
  [[nodiscard]] std::vector<EachAxis> eliminated(const VecArray<D>& forces) const {
    const std::size_t n = forces.size();
    std::vector<EachAxis> x(n);
    for (std::size_t i = 0; i < n; ++i) x[place_[i]] = forces[i].array();
    for (std::size_t column = 0; column < n; ++column) {
      const EachAxis solved = x[column] *= inverse_[column];
      for (std::size_t m = offset_[column]; m < offset_[column + 1]; ++m)
        x[row_[m]] -= factor_[m].template cast<double>() * solved;
    }
    return x;
  }

  Eigen::Index axis_ = 0;            ///< axis whose matrix is added next
  std::vector<Index> place_;         ///< row of each particle, in the order of elimination
  std::vector<Index> offset_, row_;  ///< the factors by columns, without diagonals: first entry of each column; rows of
                                     ///< the entries
  std::vector<Eigen::Array<float, D, 1>> factor_;
  std::vector<EachAxis> inverse_;  ///< inverses of the factors' diagonals
};

template <int D>
class ByMultigrid final : public AxisInverse<D> {
 public:
  void add(const Matrix& matrix) override {
    const auto n = static_cast<std::size_t>(matrix.rows());
    const bool first = axes_.empty();
    if (first) offset_.assign(1, 0);
    PairMatrix& m = axes_.emplace_back().matrix;
    for (std::size_t a = 0; a < n; ++a) {
      double diagonal = 0.0;
      // The matrix is symmetric: its columns serve as rows.
      for (Matrix::InnerIterator entry(matrix, static_cast<Eigen::Index>(a)); entry; ++entry) {
        const auto column = static_cast<std::size_t>(entry.row());
        if (column == a) {
          diagonal += entry.value();
          continue;
        }
        const auto weight = static_cast<float>(-entry.value());
        diagonal += static_cast<double>(weight) + entry.value();  // keeps the sum of the row
        m.weight.push_back(weight);
        if (first) index_.push_back(static_cast<Index>(column));
      }
      if (!(diagonal > 0.0)) not_positive();
      m.diagonal.push_back(diagonal);
      while (m.weight.size() % n_lanes != 0) {
        m.weight.push_back(0.0F);
        if (first) index_.push_back(static_cast<Index>(a));
      }
      if (first) offset_.push_back(static_cast<Index>(index_.size()));
    }
    m.weight.shrink_to_fit();
    index_.shrink_to_fit();
    for (Axis& axis : axes_) axis.matrix.column = {offset_, index_, {}, {}};
    axes_.back().multigrid = std::make_unique<Multigrid>(axes_.back().matrix);
  }

  [[nodiscard]] VecArray<D> displacements(const VecArray<D>& forces) const override {
    const std::size_t n = forces.size();
    VecArray<D> moved(n);
    ScalarArray force(n), x(n), z(n);
    const Domain domain;  // one process has all of the soil
    for (int axis = 0; axis < D; ++axis) {
      const Axis& own = axes_[static_cast<std::size_t>(axis)];
      for (std::size_t i = 0; i < n; ++i) force[i] = forces[i][axis];
      std::fill(x.begin(), x.end(), 0.0);
      own.multigrid->cycle(force, z);  // this is also the first step of the iteration
      const double energy = domain.dot(force, z);
      if (energy > 0.0)
        reduce_residual(
            domain, [&](auto u, auto y) { own.matrix.apply(u, y); },
            [&, known = true](auto r, auto step) mutable {
              if (known)
                std::copy(z.begin(), z.end(), step.begin());
              else
                own.multigrid->cycle(r, step);
              known = false;
            },
            force, x, 0.0, statics::most_inverse_iterations,
            statics::inverse_accuracy * statics::inverse_accuracy * energy);
      for (std::size_t i = 0; i < n; ++i) moved[i][axis] = x[i];
    }
    return moved;
  }

  [[nodiscard]] double work(const VecArray<D>& forces) const override {
    const VecArray<D> moved = displacements(forces);
    double sum = 0.0;
    for (std::size_t i = 0; i < forces.size(); ++i) sum += forces[i].dot(moved[i]);
    return sum;
  }

 private:
  struct Axis {
    PairMatrix matrix;
    std::unique_ptr<Multigrid> multigrid;
  };
  std::vector<Index> offset_, index_;  ///< columns of the rows, common to all axes
  std::deque<Axis> axes_;              ///< a deque, so that addresses remain valid
};

}  // namespace

template <int D>
std::unique_ptr<AxisInverse<D>> by_factors() {
  return std::make_unique<Factors<D>>();
}

template <int D>
std::unique_ptr<AxisInverse<D>> by_multigrid() {
  return std::make_unique<ByMultigrid<D>>();
}

template std::unique_ptr<AxisInverse<2>> by_factors();
template std::unique_ptr<AxisInverse<3>> by_factors();
template std::unique_ptr<AxisInverse<2>> by_multigrid();
template std::unique_ptr<AxisInverse<3>> by_multigrid();

}  // namespace poretwin::solid
