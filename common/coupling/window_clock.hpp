// Chooses exchange windows so that output instants and the end are hit exactly; used by the coupler and by a phase run
// alone.
#pragma once

#include "common/core/archive.hpp"

#include <cstdint>
#include <optional>

namespace poretwin::coupling {

class WindowClock {
 public:
  struct Settings {
    double end = 0.0;               ///< s
    std::optional<double> longest;  ///< s, of a window
    double output_interval = 0.0;   ///< s between frames; 0: only the first and the last
    double gauge_interval = 0.0;    ///< s between gauge readings; 0: every window. Gauges do not shorten windows
  };
  struct Plan {
    double start = 0.0, interval = 0.0, end = 0.0;  ///< s; end is exact where it is an output instant
    bool record_frame = false, record_gauges = false;
  };

  explicit WindowClock(Settings settings) : settings_(settings) {}

  /// The next window, no longer than `proposed` [s]. Throws Error when the window has collapsed to nothing.
  [[nodiscard]] Plan plan(double proposed) const;
  /// The window stands: time moves on.
  void accept(const Plan& plan);
  [[nodiscard]] bool finished() const { return time_ >= settings_.end; }
  [[nodiscard]] double time() const { return time_; }
  [[nodiscard]] double end() const { return settings_.end; }
  void archive(Archive& archive) { archive(time_, frames_, gauges_); }

 private:
  /// Multiples of `interval` are counted, not summed, so that rounding does not add up.
  [[nodiscard]] double next_multiple(double interval, std::uint64_t passed) const;

  Settings settings_;
  double time_ = 0.0;
  std::uint64_t frames_ = 0, gauges_ = 0;  ///< output and gauge instants passed
};

}  // namespace poretwin::coupling
