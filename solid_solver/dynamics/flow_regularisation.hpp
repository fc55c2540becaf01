// Regularisation of flowing soil by averages and by corrections proportional to the strain. It removes noise of the
// stress, evens out the packing and keeps the density consistent with the stress. No force is involved that would brake
// the flow, and soil at rest does not change.
#pragma once

#include "solid_solver/setup.hpp"

namespace poretwin::solid {

/// Corrects the soil that has flowed (plastic strain above setup.flow_limit) whenever waves have travelled three
/// spacings; dt [s] is added to the time since the last correction. To be called between the motion of a step and the
/// evaluation of its forces. After a step from equilibrium to equilibrium (in_equilibrium) it also evens out the stress
/// of soil that yielded a little with that of its neighbours, by at most an amount proportional to the plastic strain
/// since the last correction.
///   stress   its departure from the neighbours' linear fields is halved
///   volume   moves by a fifth towards the neighbours'; inside the soil a tenth of the error of sum V W, relative to
///            that of the initial lattice, is removed
///   packing  particles move down the gradient of sum V W, in proportion to the shear strain; not at surfaces
///   density  soil sheared at constant volume (psi = 0) dilates where it is denser than its pressure explains and
///            contracts where it is looser, d eps_v = 2 (rho/rho_0 - 1 - p/K) d gamma, so that errors of the volume do
///            not accumulate
template <int D>
void keep_flow_regular(const Setup<D>& setup, double dt, bool in_equilibrium, State<D>& state);

}  // namespace poretwin::solid
