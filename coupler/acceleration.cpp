#include "coupler/acceleration.hpp"

#include "common/numerics/dense.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin::coupling {
namespace {

using Vector = Eigen::VectorXd;

/// Relaxation factor of the first step, where no earlier residual exists.
constexpr double first_relaxation = 0.5;

class Plain final : public Acceleration {
 public:
  Vector next(const Vector&, const Vector& result) override { return result; }
};

/// Aitken's relaxation for vectors, in the form of Irons & Tuck (1969). The factor is that of a secant through the last
/// two residuals, projected on their difference.
class Aitken final : public Acceleration {
 public:
  Vector next(const Vector& x, const Vector& result) override {
    const Vector residual = result - x;
    if (last_.size() == residual.size()) {
      const Vector change = residual - last_;
      const double square = change.squaredNorm();
      if (square > 0.0) factor_ *= -last_.dot(change) / square;
    }
    last_ = residual;
    return x + factor_ * residual;
  }

 private:
  double factor_ = first_relaxation;
  Vector last_;
};

/// Interface quasi-Newton with the inverse Jacobian from a least-squares model, IQN-ILS (Degroote, Bathe & Vierendeels
/// 2009).
class QuasiNewton final : public Acceleration {
 public:
  Vector next(const Vector& x, const Vector& result) override {
    const Vector residual = result - x;
    if (last_residual_.size() != residual.size()) {
      changes_.resize(residual.size(), 0);
      steps_.resize(residual.size(), 0);
    } else {
      append(residual - last_residual_, result - last_result_);
    }
    last_residual_ = residual;
    last_result_ = result;
    if (changes_.cols() == 0) return x + first_relaxation * residual;
    // Columns count only as far as they are linearly independent beyond rounding.
    return result + steps_ * least_squares(changes_, -residual, 1e-10);
  }

 private:
  static constexpr Eigen::Index most_columns = 40;
  void append(const Vector& change, const Vector& step) {
    if (!(change.squaredNorm() > 0.0)) return;
    add(changes_, change);
    add(steps_, step);
  }
  static void add(Eigen::MatrixXd& columns, const Vector& column) {
    if (columns.cols() == most_columns) columns = columns.rightCols(most_columns - 1).eval();
    columns.conservativeResize(column.size(), columns.cols() + 1);
    columns.rightCols(1) = column;
  }

  Eigen::MatrixXd changes_, steps_;  ///< differences between successive residuals; between successive results
  Vector last_residual_, last_result_;
};

}  // namespace

std::unique_ptr<Acceleration> make_acceleration(AccelerationKind kind) {
  switch (kind) {
    case AccelerationKind::aitken:
      return std::make_unique<Aitken>();
    case AccelerationKind::quasi_newton:
      return std::make_unique<QuasiNewton>();
    case AccelerationKind::none:
      break;
  }
  return std::make_unique<Plain>();
}

}  // namespace poretwin::coupling
