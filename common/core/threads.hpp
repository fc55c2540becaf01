// Work shared out over threads in fixed parts: results depend on the number of parts only, not on who is faster.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>

namespace poretwin {

/// How many threads a solver may use: the environment's PORETWIN_THREADS, 1 without it.
inline std::size_t& threads() {
  static std::size_t n = [] {
    const char* const text = std::getenv("PORETWIN_THREADS");
    return text ? static_cast<std::size_t>(std::clamp(std::atol(text), 1L, 256L)) : std::size_t{1};
  }();
  return n;
}

/// Calls work(part) for every part, each on a thread of its own; a single one in place. Nothing may be thrown.
template <class Work>
void for_each_part(std::size_t n_parts, Work&& work) {
  if (n_parts == 1) {
    work(std::size_t{0});
    return;
  }
#pragma omp parallel for schedule(static, 1) num_threads(static_cast <int>(n_parts))
  for (std::size_t part = 0; part < n_parts; ++part) work(part);
}

/// Into how many parts n entries are shared out: as many as there are threads, if each is worth one.
inline std::size_t parts_for(std::size_t n) {
  constexpr std::size_t least = 8192;
  return std::clamp<std::size_t>(n / least, 1, threads());
}

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
