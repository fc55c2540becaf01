// The whole main of a solver process: everything but the physics, which `make` brings.
#pragma once

#include "common/case/case.hpp"
#include "common/coupling/phase.hpp"

#include <functional>
#include <memory>

namespace poretwin::coupling {

/// Runs the phase that `make` creates for this role and, of the fluid's, this representation of the water; refuses
/// cases with another. Arguments: --out DIR (--connect ADDRESS [--case FILE]
/// --alone --case FILE) [--set key=value]... [--progress-fd N]. Writes OUT/<role>.summary.json unless OUT belongs to
/// another run; prints one clear message on failure. Returns the exit code.
int phase_main(int argc, char** argv, Role role, std::function<std::unique_ptr<Phase>(const Case&)> make,
               FluidCase::Representation representation = FluidCase::Representation::particles);

}  // namespace poretwin::coupling
