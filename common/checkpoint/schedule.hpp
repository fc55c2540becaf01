// When checkpoints are taken, and which are kept. Used by the process that leads a run: the coupler, or a solver that
// runs alone.
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
  bool changed_program = false;                            ///< set when a state is read that another program wrote
};

class CheckpointSchedule {
 public:
  explicit CheckpointSchedule(Checkpoints settings);
  [[nodiscard]] bool due() const;
  /// Name of the next checkpoint: a number drawn at this start of the run, and the step.
  [[nodiscard]] std::string name(std::uint64_t step) const;
  /// Names of the complete checkpoints that must not be removed yet, newest first.
  [[nodiscard]] const std::vector<std::string>& kept() const { return kept_; }
  /// Records that all processes have the checkpoint of that name on disk.
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
