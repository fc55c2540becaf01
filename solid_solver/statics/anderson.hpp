// Anderson's acceleration of a fixed-point iteration.
#pragma once

#include "common/numerics/dense.hpp"

#include <algorithm>

namespace poretwin::solid {

/// Acceleration of the iteration x += P^-1 f(x) towards f(x) = 0 (Anderson 1965; Walker & Ni 2011), with P symmetric
/// and positive definite. Of all combinations of the last moves it uses the one with the least linear prediction of f
/// in the norm of P^-1. For linear f this is GMRES. Kinks of f, such as yielding, do not stop it.
class Anderson {
 public:
  Anderson(Eigen::Index size, Eigen::Index depth)
      : moves_(size, depth), changes_(size, depth), turns_(size, depth), products_(depth, depth) {}

  /// The next move of x. missing: f(x), step: P^-1 f(x), both at the present x.
  Eigen::VectorXd move(const Eigen::VectorXd& missing, const Eigen::VectorXd& step) {
    const auto held = std::min(count_, moves_.cols());
    if (count_ > 0) {
      const Eigen::Index last = (count_ - 1) % moves_.cols();
      changes_.col(last) = missing - missing_;
      turns_.col(last) = step - step_;
      products_.col(last).head(held).noalias() = turns_.leftCols(held).transpose() * changes_.col(last);
      products_.row(last).head(held) = products_.col(last).head(held).transpose();
    }
    missing_ = missing;
    step_ = step;
    Eigen::VectorXd move = step;
    if (held > 0) {
      const auto turns = turns_.leftCols(held);
      const Eigen::VectorXd expected = turns.transpose() * missing;
      const Eigen::VectorXd share = shortest_solution(products_.topLeftCorner(held, held), expected);
      move.noalias() -= moves_.leftCols(held) * share;
      move.noalias() -= turns * share;
    }
    moves_.col(count_++ % moves_.cols()) = move;
    return move;
  }

 private:
  Eigen::MatrixXd moves_, changes_, turns_;  ///< changes in the last moves: of x, of f, of P^-1 f
  Eigen::MatrixXd products_;                 ///< turns^T changes; symmetric because P is symmetric
  Eigen::VectorXd missing_, step_;
  Eigen::Index count_ = 0;
};

}  // namespace poretwin::solid
