// Ctrl-C and SIGTERM set a flag that the loops read, so that a step is finished and written before a process ends.
#pragma once

namespace poretwin::coupling {

/// Time after a first signal in which further ones are ignored [s]: schedulers and timeout(1) send one to every process
/// and to the group as well, which must not prevent the checkpoint.
inline constexpr int stop_grace = 10;

/// While it exists, SIGINT and SIGTERM only set a flag; one that comes later than stop_grace after the first ends the
/// process at once. Broken pipes and files at their size limit become errors.
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
