// How long pair lists stay valid: until neighbours have moved relative to each other.
#pragma once

#include "solid_solver/setup.hpp"

namespace poretwin::solid {

/// Whether the lists still contain all pairs of particles and images within the kernel's reach. They do while no
/// particle has moved by more than half the skin. Beyond that they do if in every tile the particles have moved
/// together with those around them, and if no particle that has moved farther is near a wall or a periodic side, where
/// images may move in the opposite direction. Where several ranks share the soil, they do for this rank's particles
/// while none has moved by more than half the skin: a rank cannot see how particles move together that it has no copies
/// of.
template <int D>
bool lists_hold(const Setup<D>& setup, const Particles<D>& particles, const Neighbourhood<D>& near);

}  // namespace poretwin::solid
