// Anderson's acceleration of a fixed-point iteration.
#pragma once

#include <Eigen/Dense>

#include <algorithm>

namespace poretwin::solid {

/// Acceleration of x += P^-1 f(x) towards f(x) = 0 (Anderson 1965; Walker & Ni 2011), P symmetric and positive: of all
/// combinations of the last moves the one whose linear prediction of f is least in the norm of P^-1. Where f is linear
/// this is GMRES; kinks of f, such as yielding, do not stop it.
class Anderson {
 public:
  Anderson(Eigen::Index size, Eigen::Index depth) : moves_(size, depth), changes_(size, depth), turns_(size, depth) {}

  /// The next move of x. missing: f(x); step: P^-1 f(x), at the x that the last move led to.
  Eigen::VectorXd move(const Eigen::VectorXd& missing, const Eigen::VectorXd& step) {
    if (count_ > 0) {
      const Eigen::Index last = (count_ - 1) % moves_.cols();
      changes_.col(last) = missing - missing_;
      turns_.col(last) = step - step_;
    }
    missing_ = missing;
    step_ = step;
    const auto held = std::min(count_, moves_.cols());
    Eigen::VectorXd move = step;
    if (held > 0) {
      const auto turns = turns_.leftCols(held);
      const Eigen::MatrixXd products = turns.transpose() * changes_.leftCols(held);
      const Eigen::VectorXd expected = turns.transpose() * missing;
      move -= (moves_.leftCols(held) + turns) * products.completeOrthogonalDecomposition().solve(expected);
    }
    moves_.col(count_++ % moves_.cols()) = move;
    return move;
  }

 private:
  Eigen::MatrixXd moves_, changes_, turns_;  ///< of the last moves: x, f, P^-1 f
  Eigen::VectorXd missing_, step_;
  Eigen::Index count_ = 0;
};

}  // namespace poretwin::solid
