// One window of the iterated scheme: which of the solid's fields are iterated, when they have converged, and what the
// fluid is given next.
#pragma once

#include "common/coupling/border.hpp"
#include "coupler/acceleration.hpp"

#include <optional>

namespace poretwin::coupling {

struct IterationSettings {
  AccelerationKind acceleration = AccelerationKind::quasi_newton;
  double tolerance = 1e-6;  ///< of every iterated field: norm of what an iteration changes, over the field's norm
};

/// Passes through one window after which it is refused and tried again at half its length.
inline constexpr int most_iterations = 50;

class WindowIteration {
 public:
  WindowIteration(const IterationSettings& settings, const Contract& solid);

  /// To be called after both sides have crossed the window, the fluid with `given`, the solid ending at `found`.
  /// Returns nothing when the iteration has converged; otherwise what the fluid is given next.
  std::optional<Snapshot> next(const Snapshot& given, const Snapshot& found);

 private:
  /// The iterated fields as one vector, every field over its norm in the first iteration.
  [[nodiscard]] Eigen::VectorXd packed(const Snapshot& snapshot) const;
  [[nodiscard]] bool converged(const Snapshot& given, const Snapshot& found) const;

  IterationSettings settings_;
  std::vector<std::string> fields_;
  std::vector<double> scale_;  ///< of every iterated field
  std::unique_ptr<Acceleration> acceleration_;
};

}  // namespace poretwin::coupling
