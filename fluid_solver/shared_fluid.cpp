#include "fluid_solver/shared_fluid.hpp"

#include "common/core/error.hpp"
#include "fluid_solver/fluid.hpp"

namespace poretwin::fluid {

namespace {

const Case& alone(const Case& scene) {
  if (scene.coupled())
    throw CaseError(
        "several ranks cannot share this water yet: [[soil]]: its soil moves; set solid.model = \"rigid\", or run the "
        "case on one rank");
  return scene;
}

}  // namespace

template <int D>
SharedFluid<D>::SharedFluid(const Case& scene, std::shared_ptr<Tiling<D>> tiling)
    : ranks::SharedPhase<Fluid<D>, D>(alone(scene), std::move(tiling)) {}

template <int D>
coupling::Publication SharedFluid<D>::publish() const {
  throw Error(ExitCode::failure, "several ranks cannot take part in a coupled run yet");
}

template class SharedFluid<2>;
template class SharedFluid<3>;

template <int D>
std::unique_ptr<Phase> make_shared_fluid(const Case& scene, std::shared_ptr<Tiling<D>> tiling) {
  return std::make_unique<SharedFluid<D>>(scene, std::move(tiling));
}
template std::unique_ptr<Phase> make_shared_fluid<2>(const Case&, std::shared_ptr<Tiling<2>>);
template std::unique_ptr<Phase> make_shared_fluid<3>(const Case&, std::shared_ptr<Tiling<3>>);

}  // namespace poretwin::fluid
