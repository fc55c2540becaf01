// What keeps soil that flows regular: stress without noise, an even packing, a density that is that of the packing; and
// the stress of soil that yields a little.
// Averages and corrections in proportion to the strain only: no force that could brake, nothing where soil rests.
#pragma once

#include "solid_solver/setup.hpp"

namespace poretwin::solid {

/// Counts the time dt [s] of a substep; whenever waves have travelled three spacings, treats the soil that has flowed
/// (plastic strain above setup.flow_limit). To be called between a step's motion and its forces. Where the step went
/// from equilibrium to equilibrium the stress of soil that yielded a little is evened out as well, with that of what
/// lies beside it, and by no more than in proportion to how much it yielded since.
///   stress   half of what its neighbours' linear fields do not explain is averaged away
///   volume   a fifth towards its neighbours'; inside the soil a tenth towards the positions' own, sum V W = 1
///   packing  particles move down the gradient of crowding, in proportion to the shear strain; not at surfaces
///   density  soil sheared at constant volume (psi = 0) that is denser than its pressure explains dilates, looser soil
///            contracts: d eps_v = 2 (rho/rho_0 - 1 - p/K) d gamma, so that errors of the volume cannot add up
template <int D>
void keep_flow_regular(const Setup<D>& setup, double dt, bool in_equilibrium, State<D>& state);

}  // namespace poretwin::solid
