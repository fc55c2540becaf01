// The whole main of a solver process: everything but the physics, which `make` brings.
#pragma once

#include "common/case/case.hpp"
#include "common/coupling/phase.hpp"

#include <functional>
#include <memory>

namespace poretwin::coupling {

/// Runs what has this role, and, of the fluid's, carries the water in this representation; refuses cases of another.
/// Arguments: --out DIR (--connect ADDRESS [--case FILE] | --alone --case FILE) [--set key=value]... [--progress-fd N].
/// Writes OUT/<role>.summary.json unless OUT is another run's; prints one clear message on failure. Returns the exit
/// code.
int phase_main(int argc, char** argv, Role role, std::function<std::unique_ptr<Phase>(const Case&)> make,
               FluidCase::Representation representation = FluidCase::Representation::particles);

}  // namespace poretwin::coupling
