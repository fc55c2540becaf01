#include "common/coupling/interrupt.hpp"

#include <atomic>
#include <csignal>
#include <ctime>

namespace poretwin::coupling {
namespace {

// A signal handler may use static storage only.
std::atomic<long> first_signal = 0;  // time of the first signal, s of CLOCK_MONOTONIC; 0: none
static_assert(std::atomic<long>::is_always_lock_free);

extern "C" void note_signal(int number) {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  long none = 0;
  const long seconds = now.tv_sec + 1;  // + 1, so that it is never 0
  if (first_signal.compare_exchange_strong(none, seconds) || seconds - none <= stop_grace) return;
  std::signal(number, SIG_DFL);
  std::raise(number);
}

}  // namespace

InterruptGuard::InterruptGuard() {
  first_signal = 0;
  struct sigaction action {};
  action.sa_handler = note_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  sigaction(SIGUSR1, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

InterruptGuard::~InterruptGuard() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
  std::signal(SIGUSR1, SIG_DFL);
}

bool interrupted() { return first_signal.load(std::memory_order_relaxed) != 0; }

}  // namespace poretwin::coupling
