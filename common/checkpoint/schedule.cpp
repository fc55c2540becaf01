#include "common/checkpoint/schedule.hpp"

#include <fmt/format.h>

#include <random>

namespace poretwin {

CheckpointSchedule::CheckpointSchedule(Checkpoints settings) : settings_(settings) {
  std::random_device source;
  start_ = fmt::format("{:08x}", source());
}

bool CheckpointSchedule::due() const {
  return settings_.store != nullptr && std::chrono::duration<double>(Clock::now() - last_).count() >= settings_.every;
}

std::string CheckpointSchedule::name(std::uint64_t step) const { return fmt::format("{}-{:08}", start_, step); }

void CheckpointSchedule::committed(const std::string& name) {
  kept_.insert(kept_.begin(), name);
  if (kept_.size() > checkpoint_generations) kept_.resize(checkpoint_generations);
  last_ = Clock::now();
}

}  // namespace poretwin
