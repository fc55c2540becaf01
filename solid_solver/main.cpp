// The solid process.
#include "common/coupling/phase_main.hpp"
#include "solid_solver/solid.hpp"

int main(int argc, char** argv) {
  return poretwin::coupling::phase_main(argc, argv, poretwin::coupling::Role::solid, poretwin::solid::make_solid);
}
