// The solid process.
#include "common/coupling/phase_main.hpp"
#include "solid_solver/safety_of_run.hpp"
#include "solid_solver/solid.hpp"

int main(int argc, char** argv) {
  if (poretwin::solid::asks_for_safety(argc, argv)) return poretwin::solid::safety_main(argc, argv);
  return poretwin::coupling::phase_main(argc, argv, poretwin::coupling::Role::solid, poretwin::solid::make_solid);
}
