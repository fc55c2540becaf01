// The process of pore water as a field, in the fluid's role.
#include "common/coupling/phase_main.hpp"
#include "pore_solver/pore_phase.hpp"

int main(int argc, char** argv) {
  return poretwin::coupling::phase_main(argc, argv, poretwin::coupling::Role::fluid, poretwin::pore::make_pore_water,
                                        poretwin::FluidCase::Representation::field);
}
