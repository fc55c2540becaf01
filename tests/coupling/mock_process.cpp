// A solver process around a mock: "mock-process fluid|solid ARGUMENTS OF phase_main". Every step takes some milliseconds, so that a
// test can kill, stop or interrupt it in the middle of a run.
#include "common/coupling/mock.hpp"
#include "common/coupling/phase_main.hpp"

#include <string>

using namespace poretwin;
using namespace poretwin::coupling;

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const Role role = std::string(argv[1]) == "fluid" ? Role::fluid : Role::solid;
  return phase_main(argc - 1, argv + 1, role, [role](const Case& scene) -> std::unique_ptr<Phase> {
    const int dimension = scene.general.dimension;
    const std::vector<double> zero(static_cast<std::size_t>(dimension), 0.0), one(static_cast<std::size_t>(dimension), 1.0);
    MockKnobs knobs;
    knobs.per_step = std::chrono::milliseconds(5);
    knobs.digest = "";  // phase_main puts in the case's
    return std::make_unique<MockPhase>(
        role, dimension, [=](double t) { return formula_publication(role, t, lattice_points(dimension, zero, one, 0.1)); }, knobs);
  });
}
