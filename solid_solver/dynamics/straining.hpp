// Effect of a velocity gradient on the soil: volumes, stresses and plastic strains.
#pragma once

#include "solid_solver/setup.hpp"

namespace poretwin::solid {

/// Advances volume, stress, plastic strain, `rubbing` and `yielded` of every particle that is awake by dt [s], with the
/// velocity gradient of its node, for four particles of one soil at a time. duration [s]: time that the strain takes,
/// for materials whose strength depends on its rate (Condition::duration).
template <int D>
void strain(const Setup<D>& setup, double dt, double duration, State<D>& state);

}  // namespace poretwin::solid
