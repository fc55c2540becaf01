// Loops on several threads. The range is divided into fixed parts, so that results depend on the number of parts, but
// not on which thread is faster.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace poretwin {

/// Number of threads that a solver may use: OMP_NUM_THREADS, otherwise the number of cores.
std::size_t threads();

/// Calls work(object, part) for every part. The calling thread takes one part after the other; other threads help if
/// there is a free core. On a busy machine the caller therefore waits only until helpers have finished the parts that
/// they have begun. Helpers sleep between calls. Of simultaneous or nested calls, helpers join only one; the others run
/// on their own thread.
void share_parts(std::size_t n_parts, void (*work)(const void* object, std::size_t part), const void* object);

/// Calls work(part) for every part, in parallel on all available threads. `work` must not throw.
template <class Work>
void for_each_part(std::size_t n_parts, Work&& work) {
  if (n_parts < 2) {
    for (std::size_t part = 0; part < n_parts; ++part) work(part);
    return;
  }
  using Called = std::remove_reference_t<Work>;
  share_parts(
      n_parts, [](const void* object, std::size_t part) { (*static_cast<Called*>(const_cast<void*>(object)))(part); },
      std::addressof(work));
}

/// Number of entries from which on several threads are worth their overhead, where the work per entry is small.
inline constexpr std::size_t worth_threads = 32768;

/// Number of parts for n entries. `worth`: number of entries from which on several threads are worth their overhead.
inline std::size_t parts_for(std::size_t n, std::size_t worth = worth_threads) { return n < worth ? 1 : threads(); }

/// Number of parts. There are several for each thread, so that a thread that starts late still finds a part to do.
inline std::size_t small_parts_for(std::size_t n, std::size_t worth = worth_threads) {
  constexpr std::size_t each = 4;
  const std::size_t parts = parts_for(n, worth);
  return parts > 1 ? each * parts : 1;
}

/// Calls work(first, last) in parallel for small parts of 0 .. n - 1. Only for work on single entries whose result does
/// not depend on how the range is divided.
template <class Work>
void parallel_ranges(std::size_t n, std::size_t worth, Work&& work) {
  const std::size_t parts = small_parts_for(n, worth);
  for_each_part(parts, [&](std::size_t part) { work(n * part / parts, n * (part + 1) / parts); });
}

template <class Work>
void parallel_ranges(std::size_t n, Work&& work) {
  parallel_ranges(n, worth_threads, std::forward<Work>(work));
}

/// Calls work(i) in parallel for every i of 0 .. n - 1.
template <class Work>
void parallel_for(std::size_t n, Work&& work) {
  parallel_ranges(n, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) work(i);
  });
}

/// Whether holds(i) is true for every i of 0 .. n - 1 of this rank; evaluated in parallel. Only for shortcuts that
/// change no result: decisions about a run must consider all ranks (Domain::all_of).
template <class Holds>
bool parallel_all(std::size_t n, const Holds& holds) {
  std::atomic<bool> all{true};
  parallel_ranges(n, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last && all.load(std::memory_order_relaxed); ++i)
      if (!holds(i)) all.store(false, std::memory_order_relaxed);
  });
  return all;
}

}  // namespace poretwin
