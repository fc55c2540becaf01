// How the processes treat memory they have freed.
#pragma once

namespace poretwin {

/// While a process sets itself up: what comes and goes only once leaves no holes in the heap.
void return_freed_memory();

/// From then on every window allocates and frees the same arrays: what is freed is kept, or the kernel hands out and
/// clears the same pages over and over (a tenth of the coupler's time).
void keep_freed_memory();

}  // namespace poretwin
