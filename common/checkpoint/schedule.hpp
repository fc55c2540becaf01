// Decides when checkpoints are written, and which are kept. The process that leads a run uses it: the coupler, or a
// solver that runs alone.
#pragma once

#include "common/checkpoint/store.hpp"

#include <chrono>
#include <limits>

namespace poretwin {

/// Whether and how a run keeps checkpoints.
struct Checkpoints {
  const CheckpointStore* store = nullptr;                  ///< nullptr: no checkpoints
  double every = std::numeric_limits<double>::infinity();  ///< s of wall-clock time; 0: after every window
  bool resume = false;                                     ///< start from the newest checkpoint
  bool changed_program = false;                            ///< set when the state was written by another program
};

class CheckpointSchedule {
 public:
  explicit CheckpointSchedule(Checkpoints settings);
  [[nodiscard]] bool due() const;
  /// Name of the next checkpoint: a number drawn when the run starts or resumes, and the step.
  [[nodiscard]] std::string name(std::uint64_t step) const;
  /// Names of the complete checkpoints that must not be removed yet, newest first.
  [[nodiscard]] const std::vector<std::string>& kept() const { return kept_; }
  /// Records that all processes have written the checkpoint of that name to disk.
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
