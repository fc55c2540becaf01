// The main function of a solver process, except for the physics, which `make` supplies.
#pragma once

#include "common/case/case.hpp"
#include "common/coupling/phase.hpp"

#include <functional>
#include <memory>

namespace poretwin::coupling {

/// Runs the phase that `make` creates. Refuses cases for another role and, if the role is fluid, cases for another
/// representation of the water. Arguments: --out DIR (--connect ADDRESS [--case FILE] | --alone --case FILE) [--set
/// key=value]... [--progress-fd N]. Writes OUT/<role>.summary.json unless OUT belongs to another run. Prints one clear
/// message on failure. Returns the exit code.
int phase_main(int argc, char** argv, Role role, std::function<std::unique_ptr<Phase>(const Case&)> make,
               FluidCase::Representation representation = FluidCase::Representation::particles);

}  // namespace poretwin::coupling
