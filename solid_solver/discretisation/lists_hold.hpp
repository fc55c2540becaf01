// For how long pair lists hold: not until something has moved, but until neighbours have moved against each other.
#pragma once

#include "solid_solver/setup.hpp"

namespace poretwin::solid {

/// Whether no two particles or images can have come within the kernel's reach that are not in the lists. True while all
/// have moved by less than half the skin; else where, tile by tile, particles have moved along with those around them,
/// and nobody who has moved by more is near a wall's or a periodic side's plane, whose images move against him.
template <int D>
bool lists_hold(const Setup<D>& setup, const Particles<D>& particles, const Neighbourhood<D>& near);

}  // namespace poretwin::solid
