// The main function of a solver that several processes, its ranks, may compute together.
#pragma once

#include "common/case/case.hpp"
#include "common/coupling/phase.hpp"
#include "common/particles/tiling.hpp"

#include <functional>
#include <memory>

namespace poretwin::ranks {

/// How the phase of a case is made: by one process, or as one rank's part of it. A part that refuses the case must
/// throw before it has sent anything.
struct MakePhase {
  std::function<std::unique_ptr<Phase>(const Case&)> whole;
  std::function<std::unique_ptr<Phase>(const Case&, std::shared_ptr<Tiling<2>>)> part_2d;
  std::function<std::unique_ptr<Phase>(const Case&, std::shared_ptr<Tiling<3>>)> part_3d;
};

/// coupling::phase_main() for a process that runs alone. Where mpirun started several processes, rank 0 does what
/// phase_main() does, and the others compute their parts of its phase. Refuses several processes in a build without
/// MPI. Returns the exit code.
int phase_main(int argc, char** argv, coupling::Role role, const MakePhase& make);

/// As phase_main(), in one of several processes that mpirun started together.
int phase_main_over_mpi(int argc, char** argv, coupling::Role role, const MakePhase& make);

}  // namespace poretwin::ranks
