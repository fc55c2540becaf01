#include "common/core/threads.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <mutex>
#include <thread>
#include <vector>

namespace poretwin {
namespace {

/// Threads that help the calling thread with its work.
class Team {
 public:
  explicit Team(std::size_t members) {
    for (std::size_t k = 0; k < members; ++k) members_.emplace_back([this] { serve(); });
  }
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;
  ~Team() {
    closed_ = true;
    wake();
    for (auto& member : members_) member.join();
  }

  /// Runs all parts; only one thread at a time may call this.
  void share(std::size_t n_parts, void (*work)(const void*, std::size_t), const void* object) {
    const auto begin = Clock::now();
    work_ = work;
    object_ = object;
    done_.store(0, std::memory_order_relaxed);
    const std::uint64_t job = (ticket_.load(std::memory_order_relaxed) >> 32) + 1;
    ticket_.store(job << 32 | n_parts << 16, std::memory_order_release);
    wake();
    take_parts();
    const auto all = static_cast<std::uint32_t>(n_parts);
    const auto worked = Clock::now() - begin;
    for (std::uint32_t done = done_.load(std::memory_order_acquire); done != all;)
      done = await_change(done_, done, std::clamp<Clock::duration>(worked, waking, longest));
  }

 private:
  using Clock = std::chrono::steady_clock;
  /// `waking`: approximate time to wake a thread; `longest`: longest time of active waiting.
  static constexpr Clock::duration waking = std::chrono::microseconds(20), longest = std::chrono::microseconds(200);
  static constexpr Clock::duration soon = std::chrono::microseconds(50);

  /// Returns the value once it differs from `from`. Waits actively for the time `awake`, then sleeps until it changes.
  static std::uint32_t await_change(const std::atomic<std::uint32_t>& value, std::uint32_t from,
                                    Clock::duration awake) {
    for (const auto begin = Clock::now(); Clock::now() - begin < awake;)
      for (int look = 0; look < 16; ++look) {
        if (const std::uint32_t found = value.load(std::memory_order_acquire); found != from) return found;
        __builtin_ia32_pause();
      }
    value.wait(from, std::memory_order_acquire);
    return value.load(std::memory_order_acquire);
  }

  void wake() {
    called_.store(Clock::now().time_since_epoch().count(), std::memory_order_relaxed);
    calls_.fetch_add(1, std::memory_order_release);
    calls_.notify_all();
  }

  /// Loop of a helping thread. It waits actively for the next call as long as it worked on the present one, and for at
  /// least `waking` if the present call came soon after the thread had become idle.
  void serve() {
    Clock::duration awake{};
    for (std::uint32_t seen = 0; !closed_;) {
      const auto idle = Clock::now();
      seen = await_change(calls_, seen, awake);
      const bool came_soon = Clock::duration(called_.load(std::memory_order_relaxed)) - idle.time_since_epoch() < soon;
      const auto begin = Clock::now();
      take_parts();
      awake = std::clamp<Clock::duration>(Clock::now() - begin, came_soon ? waking : Clock::duration{}, longest);
    }
  }

  /// Works on parts until all are taken. work_ and object_ may be read only after a part has been taken: they remain
  /// unchanged until that part is done.
  void take_parts() {
    std::uint64_t ticket = ticket_.load(std::memory_order_acquire);
    for (;;) {
      const std::uint64_t n_parts = ticket >> 16 & 0xffff, part = ticket & 0xffff;
      if (part == n_parts) return;
      if (!ticket_.compare_exchange_weak(ticket, ticket + 1, std::memory_order_acq_rel)) continue;
      work_(object_, static_cast<std::size_t>(part));
      if (done_.fetch_add(1, std::memory_order_acq_rel) + 1 == n_parts) done_.notify_all();
      ticket = ticket_.load(std::memory_order_acquire);
    }
  }

  // Each has a cache line of its own, so that reading one does not delay a thread that changes another.
  alignas(64) std::atomic<std::uint64_t> ticket_{0};  ///< number of the call, of its parts, of the next part
  alignas(64) std::atomic<std::uint32_t> done_{0};
  alignas(64) std::atomic<std::uint32_t> calls_{0};
  alignas(64) std::atomic<Clock::rep> called_{0};
  std::atomic<bool> closed_{false};
  void (*work_)(const void*, std::size_t) = nullptr;
  const void* object_ = nullptr;
  std::vector<std::thread> members_;
};

}  // namespace

std::size_t threads() {
  static const auto n = [] {
    const char* given = std::getenv("OMP_NUM_THREADS");
    const int requested = given == nullptr ? 0 : std::atoi(given);
    return requested > 0 ? static_cast<std::size_t>(requested)
                         : std::max<std::size_t>(1, std::thread::hardware_concurrency());
  }();
  return n;
}

void share_parts(std::size_t n_parts, void (*work)(const void* object, std::size_t part), const void* object) {
  static std::mutex busy;
  thread_local bool within = false;
  std::unique_lock<std::mutex> alone(busy, std::defer_lock);
  if (threads() < 2 || within || !alone.try_lock()) {
    for (std::size_t part = 0; part < n_parts; ++part) work(object, part);
    return;
  }
  static Team team(threads() - 1);
  within = true;
  team.share(n_parts, work, object);
  within = false;
}

}  // namespace poretwin
