// Chooses time windows so that they end exactly at output times and at the end of the run. The coupler and a phase that
// runs alone use it.
#pragma once

#include "common/core/archive.hpp"

#include <cstdint>
#include <map>
#include <optional>
#include <string>

namespace poretwin::coupling {

class WindowClock {
 public:
  struct Settings {
    double end = 0.0;               ///< s
    std::optional<double> longest;  ///< s, longest window
    double output_interval = 0.0;   ///< s between frames; 0: only the first and the last
    double gauge_interval = 0.0;    ///< s between readings; 0: every window. Gauges do not shorten windows
    /// s: shortest characteristic time of the scene (shortest_time()). A run whose windows stay far below this is ended
    /// as stuck. 0: unknown, without such a check
    double shortest_time = 0.0;
    std::string of_what = {};  ///< name of the shortest time, for the message
  };
  struct Plan {
    double start = 0.0, interval = 0.0, end = 0.0;  ///< s; end is exact if it is an output time
    bool record_frame = false, record_gauges = false;
  };

  explicit WindowClock(Settings settings) : settings_(settings) {}

  /// The next window, at most `proposed` [s] long.
  /// Throws Error if windows have become too short to advance the time.
  [[nodiscard]] Plan plan(double proposed) const;
  /// Accepts a window and advances the time. held_by: what limited the window. Throws DivergedError if windows have
  /// stayed far below the scene's shortest time for so long that the run would not end.
  void accept(const Plan& plan, const std::string& held_by = {});
  [[nodiscard]] bool finished() const { return time_ >= settings_.end; }
  [[nodiscard]] double time() const { return time_; }
  [[nodiscard]] double end() const { return settings_.end; }
  void archive(Archive& archive) { archive(time_, frames_, gauges_); }

 private:
  /// Multiples of `interval` are counted, not summed. So rounding errors do not accumulate.
  [[nodiscard]] double next_multiple(double interval, std::uint64_t passed) const;

  Settings settings_;
  double time_ = 0.0;
  std::uint64_t frames_ = 0, gauges_ = 0;  ///< number of past output times and gauge times
  /// Number of successive windows that were far shorter than shortest_time, and the number that each cause limited. Not
  /// in checkpoints: a resumed run counts from zero.
  std::uint64_t stuck_ = 0;
  std::map<std::string, std::uint64_t> held_by_;
};

}  // namespace poretwin::coupling
