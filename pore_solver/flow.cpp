#include "pore_solver/flow.hpp"

#include "common/media/retention_law.hpp"
#include "common/media/seepage.hpp"
#include "pore_solver/capillary_flow.hpp"
#include "pore_solver/sharp_flow.hpp"

namespace poretwin::pore {

Pores rigid_pores(const Case& scene, const Network& network) {
  Pores pores;
  const std::size_t n = network.size();
  for (auto* zero : {&pores.at, &pores.give}) zero->assign(n, 0.0);
  for (std::size_t a = 0; a < n; ++a) {
    const Soil& soil = scene.soils[network.soil[a]];
    // In soil without capillarity the initial water stays with the grains, and only the rest of the pores can fill.
    pores.volume.push_back(network.volume[a] * soil.porosity * (1.0 - soil.initial_saturation));
    pores.conductivity.push_back(porous::seepage_at(scene, soil, soil.porosity).conductivity);
  }
  return pores;
}

std::unique_ptr<FlowModel> make_flow_model(const Case& scene, const Network& network) {
  if (porous::retention_law(scene.soils.front()).curve == nullptr) return std::make_unique<SharpFlow>(scene, network);
  return std::make_unique<CapillaryFlow>(scene, network);
}

}  // namespace poretwin::pore
