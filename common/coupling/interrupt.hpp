// Ctrl-C and SIGTERM as a question the loops ask: a step is finished and written before anybody leaves.
#pragma once

namespace poretwin::coupling {

/// While it lives, SIGINT and SIGTERM only set a flag; a second one ends the process at once. Broken pipes and files at
/// their limit become errors.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
};

/// Has a person (or a supervisor) asked this process to stop?
bool interrupted();

}  // namespace poretwin::coupling
