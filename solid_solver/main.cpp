// The solid process.
#include "common/ranks/phase_main.hpp"
#include "solid_solver/safety_of_run.hpp"
#include "solid_solver/solid.hpp"

int main(int argc, char** argv) {
  if (poretwin::solid::asks_for_safety(argc, argv)) return poretwin::solid::safety_main(argc, argv);
  using namespace poretwin::solid;
  return poretwin::ranks::phase_main(argc, argv, poretwin::coupling::Role::solid,
                                     {make_solid, make_shared_solid<2>, make_shared_solid<3>});
}
