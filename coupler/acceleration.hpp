// Acceleration of a fixed-point iteration x <- H(x), where H is one pass through both solvers. Every window starts
// anew, so that checkpoints need not contain anything of it.
#pragma once

#include <Eigen/Core>

#include <memory>

namespace poretwin::coupling {

enum class AccelerationKind {
  none,         ///< x <- H(x): diverges where the solid is lighter than the water that moves with it
  aitken,       ///< one relaxation factor, from the last two residuals
  quasi_newton  ///< an inverse Jacobian fitted by least squares to the iterations of this window
};

class Acceleration {
 public:
  Acceleration() = default;
  Acceleration(const Acceleration&) = delete;
  Acceleration& operator=(const Acceleration&) = delete;
  virtual ~Acceleration() = default;
  /// The next x, given `result` = H(x).
  virtual Eigen::VectorXd next(const Eigen::VectorXd& x, const Eigen::VectorXd& result) = 0;
};

/// Makes an acceleration; every window needs a new one.
std::unique_ptr<Acceleration> make_acceleration(AccelerationKind kind);

}  // namespace poretwin::coupling
