// Work shared out over threads in fixed parts: results depend on the number of parts only, not on who is faster.
#pragma once

#include <cstddef>

namespace poretwin {

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

}  // namespace poretwin
