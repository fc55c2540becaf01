// Ctrl-C, SIGTERM and SIGUSR1 set a flag that the loops check, so that a window is finished and recorded before a
// process ends.
#pragma once

namespace poretwin::coupling {

/// Time [s] after the first signal during which further signals are ignored. Schedulers and timeout(1) send one signal
/// to every process and another to the group; the second must not prevent the checkpoint.
inline constexpr int stop_grace = 10;

/// While a guard exists, SIGINT, SIGTERM and SIGUSR1 (which mpirun passes on to its ranks, other than SIGINT) only set
/// a flag; a signal later than stop_grace after the first ends the process immediately. Broken pipes and files at their
/// size limit cause errors instead of signals.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
};

/// Whether a user or a supervisor has asked this process to stop.
bool interrupted();

}  // namespace poretwin::coupling
