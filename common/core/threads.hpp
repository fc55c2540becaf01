// Work shared out over threads in fixed parts: results depend on the number of parts only, not on who is faster.
#pragma once

#include <omp.h>

#include <algorithm>
#include <cstddef>

namespace poretwin {

/// How many threads a solver may use: OMP_NUM_THREADS, all cores without it.
inline std::size_t threads() {
  static const auto n = static_cast<std::size_t>(std::max(1, omp_get_max_threads()));
  return n;
}

/// Calls work(part) for every part, side by side on as many threads as there are. Nothing may be thrown.
template <class Work>
void for_each_part(std::size_t n_parts, Work&& work) {
  const std::size_t n_threads = std::min(n_parts, threads());
  if (n_threads < 2) {
    for (std::size_t part = 0; part < n_parts; ++part) work(part);
    return;
  }
#pragma omp parallel for schedule(static, 1) num_threads(static_cast <int>(n_threads))
  for (std::size_t part = 0; part < n_parts; ++part) work(part);
}

/// How many entries or particles are worth more than one thread: those wait for each other in every loop, which on a
/// busy machine takes longer than the work on fewer.
inline constexpr std::size_t worth_threads = 32768;

/// Into how many parts n entries are shared out.
inline std::size_t parts_for(std::size_t n) { return n < worth_threads ? 1 : threads(); }

/// Calls work(first, last) for parts of 0 .. n - 1. For work on single entries, which cannot depend on the parts.
template <class Work>
void side_by_side(std::size_t n, Work&& work) {
  const std::size_t parts = parts_for(n);
  for_each_part(parts, [&](std::size_t part) { work(n * part / parts, n * (part + 1) / parts); });
}

/// Calls work(i) for every entry of 0 .. n - 1, side by side.
template <class Work>
void for_each_side_by_side(std::size_t n, Work&& work) {
  side_by_side(n, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) work(i);
  });
}

}  // namespace poretwin
