// How the processes treat memory they have freed.
#pragma once

#include <malloc.h>

#include <limits>

namespace poretwin {

/// While a process sets itself up: what comes and goes only once leaves no holes in the heap.
inline void return_freed_memory() { ::mallopt(M_MMAP_THRESHOLD, 128 << 10); }

/// From then on every window allocates and frees the same arrays: what is freed is kept, or the kernel hands out and
/// clears the same pages over and over (a tenth of the coupler's time).
inline void keep_freed_memory() {
  ::mallopt(M_MMAP_THRESHOLD, 32 << 20);  // the largest that glibc takes
  ::mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
}

}  // namespace poretwin
