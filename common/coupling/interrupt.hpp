// Ctrl-C, SIGTERM and SIGUSR1 set a flag that the loops check, so that a process ends at the start or end of a window,
// with a checkpoint.
#pragma once

#include <exception>

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

/// Leaves a window before its end, since the process is to stop. Whoever runs the phase restores the saved state.
struct WindowGivenUp : std::exception {
  [[nodiscard]] const char* what() const noexcept override { return "window given up"; }
};
/// Throws WindowGivenUp if the process is to stop. Phases call it between substeps and iterations of windows whose
/// start is saved.
inline void give_up_if_interrupted() {
  if (interrupted()) throw WindowGivenUp();
}

}  // namespace poretwin::coupling
