// Regularisation of flowing soil: it removes noise of the stress, evens the packing and keeps the density consistent
// with it. It consists of averages and of corrections proportional to the strain: no force that could brake the flow,
// and no effect where soil is at rest.
#pragma once

#include "solid_solver/setup.hpp"

namespace poretwin::solid {

/// Adds a substep dt [s] to the time since the last treatment; once waves have travelled three spacings, treats the
/// soil that has flowed (plastic strain above setup.flow_limit). To be called between the motion of a step and its
/// forces. Where the step went from equilibrium to equilibrium, the stress of soil that yielded a little is evened out
/// as well, with that of what lies beside it, by no more than in proportion to how much it has yielded since.
///   stress   its departure from the linear fields around its neighbours is halved
///   volume   moves by a fifth towards its neighbours'; inside the soil by a tenth towards sum V W = 1
///   packing  particles move down the gradient of sum V W, in proportion to the shear strain; not at surfaces
///   density  soil sheared at constant volume (psi = 0) that is denser than its pressure explains dilates, looser soil
///            contracts: d eps_v = 2 (rho/rho_0 - 1 - p/K) d gamma, so that errors of the volume do not accumulate
template <int D>
void keep_flow_regular(const Setup<D>& setup, double dt, bool in_equilibrium, State<D>& state);

}  // namespace poretwin::solid
