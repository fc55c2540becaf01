// The fluid process.
#include "common/coupling/phase_main.hpp"
#include "fluid_solver/fluid.hpp"

int main(int argc, char** argv) {
  return poretwin::coupling::phase_main(argc, argv, poretwin::coupling::Role::fluid, poretwin::fluid::make_fluid);
}
