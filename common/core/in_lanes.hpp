// Parallel loops whose body works on lanes, compiled for the machine on which they run.
#pragma once

#include "common/core/lanes.hpp"
#include "common/core/threads.hpp"

namespace poretwin {

/// Calls work(i) for every i of 0 .. n - 1, compiled for this machine. From `worth` entries on, several threads run in
/// parallel. Mark `work` always_inline.
template <class Work>
void for_each_in_lanes(std::size_t n, std::size_t worth, const Work& work) {
  parallel_ranges(n, worth, [&](std::size_t first, std::size_t last) {
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
