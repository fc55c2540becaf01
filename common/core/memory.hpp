// How the processes treat freed memory.
#pragma once

namespace poretwin {

/// During set-up: returns freed memory to the kernel, so that arrays needed only once leave no holes in the heap.
void return_freed_memory();

/// After set-up: keeps freed memory, since every window allocates and frees the same arrays. Otherwise the kernel would
/// provide and clear the same pages again and again (a tenth of the coupler's time).
void keep_freed_memory();

}  // namespace poretwin
