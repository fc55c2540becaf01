// A solver that mpirun starts as several processes, its ranks, which share the soil or the water.
#pragma once

#include "cli/run.hpp"
#include "common/case/case.hpp"

namespace poretwin::cli {

/// Throws CaseError where several processes cannot compute this case on this machine.
void expect_tiles(const RunOptions& options, const Case& scene);

/// The same program, started by mpirun as so many ranks, on the machines of the options; for one rank, the program
/// itself. Ranks are not bound to cores, since other programs may compute there. mpirun passes on output and SIGUSR1;
/// it does not pass on other descriptors, and SIGINT makes it kill the ranks.
Program over_ranks(const RunOptions& options, Program solver);

}  // namespace poretwin::cli
