#include "common/ranks/phase_main.hpp"

#include "common/core/error.hpp"
#include "common/coupling/summary.hpp"

namespace poretwin::ranks {

int phase_main_over_mpi(int, char**, coupling::Role role, const MakePhase&) {
  coupling::log_line(std::string(to_string(role)) +
                     ": error: mpirun started several processes, and this program was built without MPI: install "
                     "libopenmpi-dev, openmpi-bin and libtrilinos-zoltan-dev and build it anew, or start one process");
  return static_cast<int>(ExitCode::failure);
}

}  // namespace poretwin::ranks
