#include "pore_solver/flow.hpp"

#include "common/media/retention_law.hpp"
#include "pore_solver/capillary_flow.hpp"
#include "pore_solver/sharp_flow.hpp"

namespace poretwin::pore {

std::unique_ptr<FlowModel> make_flow_model(const Case& scene, const Network& network) {
  if (porous::retention_law(scene.soils.front()).curve == nullptr) return std::make_unique<SharpFlow>(scene, network);
  return std::make_unique<CapillaryFlow>(scene, network);
}

}  // namespace poretwin::pore
