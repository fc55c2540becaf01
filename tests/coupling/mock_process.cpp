// A solver process made of a mock: "mock-process fluid|solid ARGUMENTS OF phase_main", or, under the name
// poretwin-fluid or poretwin-solid, the arguments alone. Every step takes some milliseconds, so that a test can kill,
// stop or interrupt it during a run. PORETWIN_MOCK_NAN_AT=STEP publishes NaN; PORETWIN_MOCK_DIMENSION=D announces
// another dimension. The solid's velocity grows with time.
#include "common/coupling/mock.hpp"
#include "common/coupling/phase_main.hpp"

#include <cstdlib>
#include <string>

using namespace poretwin;
using namespace poretwin::coupling;

namespace {

int number_from(const char* variable, int otherwise) {
  const char* text = std::getenv(variable);
  return text != nullptr ? std::atoi(text) : otherwise;
}

}  // namespace

int main(int argc, char** argv) {
  std::string called = argv[0];
  if (const bool by_name = called.ends_with("poretwin-fluid") || called.ends_with("poretwin-solid"); !by_name) {
    if (argc < 2) return 2;
    called = argv[1];
    --argc;
    ++argv;
  }
  const Role role = called.ends_with("fluid") ? Role::fluid : Role::solid;
  return phase_main(argc, argv, role, [role](const Case& scene) -> std::unique_ptr<Phase> {
    const int dimension = number_from("PORETWIN_MOCK_DIMENSION", scene.general.dimension);
    const std::vector<double> zero(static_cast<std::size_t>(dimension), 0.0),
        one(static_cast<std::size_t>(dimension), 1.0);
    MockKnobs knobs;
    knobs.per_step = std::chrono::milliseconds(5);
    knobs.nan_at = static_cast<std::uint64_t>(number_from("PORETWIN_MOCK_NAN_AT", 0));
    knobs.digest = "";  // phase_main sets that of the case
    return std::make_unique<MockPhase>(
        role, dimension,
        [=](double t) {
          Publication out = formula_publication(role, t, lattice_points(dimension, zero, one, 0.1));
          for (auto& field : out.fields)
            if (field.name == field::solid_velocity) field.values.assign(field.values.size(), 1.0 + t);
          return out;
        },
        knobs);
  });
}
