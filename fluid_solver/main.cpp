// The fluid process.
#include "common/coupling/phase_main.hpp"
#include "fluid_solver/fluid.hpp"

#include <malloc.h>

int main(int argc, char** argv) {
  // Every window builds its lists anew: memory given back to the system in between would be fetched again page by page.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  return poretwin::coupling::phase_main(argc, argv, poretwin::coupling::Role::fluid, poretwin::fluid::make_fluid);
}
