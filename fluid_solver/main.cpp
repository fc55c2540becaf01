// The fluid process.
#include "common/ranks/phase_main.hpp"
#include "fluid_solver/fluid.hpp"

int main(int argc, char** argv) {
  using namespace poretwin::fluid;
  return poretwin::ranks::phase_main(argc, argv, poretwin::coupling::Role::fluid,
                                     {make_fluid, make_shared_fluid<2>, make_shared_fluid<3>});
}
