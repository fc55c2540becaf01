// One window of the iterated scheme: which of the solid's fields are iterated, when they have converged, and which
// values the fluid receives in the next pass.
#pragma once

#include "common/coupling/border.hpp"
#include "coupler/acceleration.hpp"

#include <optional>

namespace poretwin::coupling {

struct IterationSettings {
  AccelerationKind acceleration = AccelerationKind::quasi_newton;
  double tolerance = 1e-6;  ///< largest norm of the change of an iterated field in an iteration, over the field's norm
};

/// Number of passes through one window after which the window is refused and repeated with half its length.
inline constexpr int most_iterations = 50;

class WindowIteration {
 public:
  WindowIteration(const IterationSettings& settings, const Contract& solid);

  /// To be called after both sides have computed the window. `given`: the solid's fields that the fluid received.
  /// `found`: those with which the solid ended. Returns nothing if the iteration has converged, otherwise the fields
  /// that the fluid receives in the next pass.
  std::optional<Snapshot> next(const Snapshot& given, const Snapshot& found);

 private:
  /// The iterated fields as one vector, each divided by its norm in the first iteration.
  [[nodiscard]] Eigen::VectorXd packed(const Snapshot& snapshot) const;
  [[nodiscard]] bool converged(const Snapshot& given, const Snapshot& found) const;

  IterationSettings settings_;
  std::vector<std::string> fields_;
  std::vector<double> scale_;  ///< divisor of every iterated field
  std::unique_ptr<Acceleration> acceleration_;
};

}  // namespace poretwin::coupling
