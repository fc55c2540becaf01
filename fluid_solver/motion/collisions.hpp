// Collisions of particles of free water that come too close.
#pragma once

#include "fluid_solver/discretisation/stencil.hpp"
#include "fluid_solver/state.hpp"

namespace poretwin::fluid {

/// Pairs closer than `motion::collision` spacings lose their speed of approach; momentum is conserved. A particle on a
/// wall loses its velocity into the wall, since the pressure of its own image cannot stop it. All ranks call this.
template <int D>
void collide(const Setup<D>& setup, const Stencil<D>& s, Particles<D>& p);

}  // namespace poretwin::fluid
