#include "common/coupling/interrupt.hpp"
#include "common/coupling/phase_main.hpp"
#include "common/ranks/led_phase.hpp"
#include "common/ranks/phase_main.hpp"
#include "common/tiles/mpi_tiling.hpp"

namespace poretwin::ranks {
namespace {

/// Space is cut anew where the rank with most particles has more than the mean by this fraction. [1] A rank with a
/// tenth more work makes the others wait for a tenth of the time; a cut costs as much as a few lists of pairs.
constexpr double imbalance = 0.1;

}  // namespace

int phase_main_over_mpi(int argc, char** argv, coupling::Role role, const MakePhase& make) {
  return tiles::run_as_rank(argc, argv, [&](const tiles::Communicator& all) {
    const MakePart part = [&](const Case& scene) {
      if (scene.general.dimension == 3)
        return make.part_3d(scene, std::make_shared<tiles::MpiTiling<3>>(all, imbalance));
      return make.part_2d(scene, std::make_shared<tiles::MpiTiling<2>>(all, imbalance));
    };
    if (all.rank() > 0) {
      // mpirun passes signals to every rank. Only the first decides when the run ends.
      const coupling::InterruptGuard guard;
      follow(all, part);
      return 0;
    }
    Leader leader(all);
    const int code =
        coupling::phase_main(argc, argv, role, [&](const Case& scene) { return leader.make(scene, part); });
    leader.end(code);
    return code;
  });
}

}  // namespace poretwin::ranks
