// Acceleration of an iteration x <- H(x), where H is one pass through both solvers. Nothing is
// remembered from one window to the next, so that checkpoints need no state of it.
#pragma once

#include <Eigen/Core>

#include <memory>

namespace poretwin::coupling {

enum class AccelerationKind {
  none,         ///< x <- H(x): diverges where the driven side is lighter than what it drives
  aitken,       ///< one relaxation factor, from the last two residuals
  quasi_newton  ///< a least-squares inverse of the Jacobian from the window's iterations
};

class Acceleration {
 public:
  Acceleration() = default;
  Acceleration(const Acceleration&) = delete;
  Acceleration& operator=(const Acceleration&) = delete;
  virtual ~Acceleration() = default;
  /// The next x after `result` = H(x).
  virtual Eigen::VectorXd next(const Eigen::VectorXd& x, const Eigen::VectorXd& result) = 0;
};

/// Makes an acceleration; each window has its own.
std::unique_ptr<Acceleration> make_acceleration(AccelerationKind kind);

}  // namespace poretwin::coupling
