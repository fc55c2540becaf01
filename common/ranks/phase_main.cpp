#include "common/ranks/phase_main.hpp"

#include "common/coupling/phase_main.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

namespace poretwin::ranks {
namespace {

/// Whether mpirun (OpenMPI, MPICH) or srun (Slurm) started several processes of this program. MPI itself is not asked:
/// to start it takes longer than a small run.
bool is_one_of_several() {
  constexpr std::array names{"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"};
  return std::ranges::any_of(names, [](const char* name) {
    const char* size = std::getenv(name);
    return size != nullptr && std::atoi(size) > 1;
  });
}

}  // namespace

int phase_main(int argc, char** argv, coupling::Role role, const MakePhase& make) {
  return is_one_of_several() ? phase_main_over_mpi(argc, argv, role, make)
                             : coupling::phase_main(argc, argv, role, make.whole);
}

}  // namespace poretwin::ranks
