// Regions at rest around flowing soil. They sleep, and wake when something changes.
//
// A particle is at rest when it has neither yielded nor moved for a while. The criterion is its displacement, not its
// velocity, since elastic waves pass through it without end. Then it is calm: near-critical damping makes these waves
// die out. It falls asleep if it and all particles around it stay calm. While it sleeps, its stress and volume are
// constant and its strain rate is zero; its neighbours are computed with these values. Sleeping particles within range
// of particles that are awake still transmit the waves of the latter.
#pragma once

#include "solid_solver/dynamics/step.hpp"

namespace poretwin::solid {

/// To be called after a substep of dt [s] under `drive`. Finds which particles move, are calm, fall asleep and wake,
/// and renews lists and forces where this changes. Does nothing before soil has flowed, or where `solid.quiet.regions`
/// is not set.
template <int D>
void watch_regions(const Setup<D>& setup, const Drive<D>& drive, double dt, State<D>& state);

/// Wakes all particles.
template <int D>
void wake_regions(const Setup<D>& setup, State<D>& state);

}  // namespace poretwin::solid
