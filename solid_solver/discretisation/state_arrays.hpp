// The arrays of the soil's state that have entries for particles, declared once, so that particles can change their
// ranks and leave the soil.
#pragma once

#include "solid_solver/setup.hpp"
#include "solid_solver/state.hpp"

#include <algorithm>

namespace poretwin::solid {

/// Calls visit(array) for every array of the regions that sleep, in which fixed particles have no part.
template <int D, class Visit>
void for_each_array(Regions<D>& regions, const Visit& visit) {
  for (auto* numbers : {&regions.last_active, &regions.sheared, &regions.saturation.values()}) visit(*numbers);
  for (auto* vectors : {&regions.mark, &regions.outside}) visit(*vectors);
  for (auto* flags : {&regions.calm, &regions.asleep}) visit(*flags);
}

/// Calls visit(array, entries per particle) for every array of the state that has entries for particles, except
/// pair lists, what is used within a step only, and the stiffness, which is found anew.
template <int D, class Visit>
void for_each_array(const Setup<D>& setup, State<D>& state, const Visit& visit) {
  Particles<D>& p = state.particles;
  std::size_t remembered = 0;
  for (const auto& model : setup.models) remembered = std::max(remembered, model->state_size());
  for (auto* vectors : {&p.position, &p.displacement, &p.velocity, &p.slip, &p.slipped, &p.wall_slope, &state.body})
    visit(*vectors, 1);
  for (auto* vectors : {&state.rest_displacement, &state.mean_velocity, &state.returned_impulse,
                        &state.external.pressure_gradient, &state.external.force, &state.sleep.force})
    visit(vectors->values(), 1);
  for (auto* numbers : {&p.mass, &p.volume, &p.plastic_strain, &state.erosion.share, &state.erosion.shear_stress})
    visit(*numbers, 1);
  External<D>& water = state.external;
  for (auto* numbers : {&water.pressure, &water.coverage, &water.saturation, &water.basin_level, &water.spreading,
                        &state.backing, &state.dilation, &state.plastic_shear_ratio, &state.sleep.saturation})
    visit(numbers->values(), 1);
  visit(p.stress, 1);
  visit(p.material, 1);
  visit(p.material_state, remembered);
  visit(p.rubbing, 1);
  visit(state.nodes, 1);
  visit(state.force, 1);
  visit(state.yielded, 1);
  visit(state.evened, 1);
  visit(state.erosion.first_number, 1);
  for_each_array(state.regions, [&](auto& array) { visit(array, 1); });
}

}  // namespace poretwin::solid
