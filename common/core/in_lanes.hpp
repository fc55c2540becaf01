// Loops over entries that are each worked on by lanes, side by side.
#pragma once

#include "common/core/lanes.hpp"
#include "common/core/threads.hpp"

namespace poretwin {

/// Calls work(i) for every entry of 0 .. n - 1, of which `worth` are worth more than one thread, side by side, compiled
/// for this machine; mark it always_inline.
template <class Work>
void for_each_in_lanes(std::size_t n, std::size_t worth, const Work& work) {
  side_by_side(n, worth, [&](std::size_t first, std::size_t last) {
    run_lanes([&]() __attribute__((always_inline)) {
      for (std::size_t i = first; i < last; ++i) work(i);
    });
  });
}
template <class Work>
void for_each_in_lanes(std::size_t n, const Work& work) {
  for_each_in_lanes(n, worth_threads, work);
}

}  // namespace poretwin
