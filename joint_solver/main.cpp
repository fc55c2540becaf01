#include "common/coupling/phase_main.hpp"
#include "joint_solver/joint_water.hpp"

int main(int argc, char** argv) {
  return poretwin::coupling::phase_main(argc, argv, poretwin::coupling::Role::fluid, poretwin::joint::make_joint_water,
                                        poretwin::FluidCase::Representation::both);
}
