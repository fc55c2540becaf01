// Ctrl-C and SIGTERM set a flag that the loops read, so that a step is finished and written before a process ends.
#pragma once

namespace poretwin::coupling {

/// After a first signal, further ones are ignored for so long [s]: schedulers and timeout(1) send one to every process
/// and to the group as well, and the checkpoint must not suffer from that.
inline constexpr int stop_grace = 10;

/// While it lives, SIGINT and SIGTERM only set a flag; one that comes later than stop_grace after the first ends the
/// process at once. Broken pipes and files at their limit become errors.
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
