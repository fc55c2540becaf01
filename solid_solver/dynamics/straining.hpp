// What a velocity gradient does to the soil: volumes, stresses and plastic strains.
#pragma once

#include "solid_solver/setup.hpp"

namespace poretwin::solid {

/// Brings volume, stress, plastic strain, `rubbing` and `yielded` of every particle awake forward by dt [s] of its
/// node's velocity gradient, four particles of one soil at a time.
template <int D>
void strain(const Setup<D>& setup, double dt, State<D>& state);

}  // namespace poretwin::solid
