// When checkpoints are taken and which are kept: for the process that leads a run, the coupler or a solver that runs
// alone.
#pragma once

#include "common/checkpoint/store.hpp"

#include <chrono>
#include <limits>

namespace poretwin {

/// Whether and how a run keeps checkpoints.
struct Checkpoints {
  const CheckpointStore* store = nullptr;                  ///< none: no checkpoints
  double every = std::numeric_limits<double>::infinity();  ///< s of wall-clock; 0: after every window
  bool resume = false;                                     ///< start from the newest
  bool changed_program = false;                            ///< of the state read: another program wrote it
};

class CheckpointSchedule {
 public:
  explicit CheckpointSchedule(Checkpoints settings);
  [[nodiscard]] bool due() const;
  /// The name of the next checkpoint, from this start of the run and this step.
  [[nodiscard]] std::string name(std::uint64_t step) const;
  /// Committed checkpoints that must not be removed yet, newest first.
  [[nodiscard]] const std::vector<std::string>& kept() const { return kept_; }
  /// Notes that the checkpoint of that name is on disk in all processes.
  void committed(const std::string& name);
  void set_kept(std::vector<std::string> names) { kept_ = std::move(names); }

 private:
  using Clock = std::chrono::steady_clock;
  Checkpoints settings_;
  std::string start_;
  Clock::time_point last_ = Clock::now();
  std::vector<std::string> kept_;
};

}  // namespace poretwin
