// CPU time of the jobs of a benchmark.
#pragma once

#include <algorithm>
#include <ctime>

namespace poretwin {

inline double cpu() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// CPU time of one call [s]: the shortest mean of batches that take 20 ms or more each, as clocks of CPU time may be
/// coarse, of as many as fit into a second (at least three).
template <class Job>
double seconds(Job&& job) {
  double least = 1e300;
  int batches = 0;
  for (const double end = cpu() + 1.0; batches < 3 || cpu() < end; ++batches) {
    int calls = 0;
    const double begin = cpu();
    double now = begin;
    for (; now < begin + 0.02; now = cpu(), ++calls) job();
    least = std::min(least, (now - begin) / calls);
  }
  return least;
}

}  // namespace poretwin
