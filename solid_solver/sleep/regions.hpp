// Regions at rest around soil that flows: they sleep, and wake when something changes.
//
// A particle is at rest when it has neither yielded nor moved for a while. Its velocity is no criterion, since elastic
// waves pass through it without end; its displacement is. It is then calm and damped near-critically, so that those
// waves die out, and falls asleep if it and all around it stay calm. Asleep, its stress and volume are frozen and its
// strain rate is zero; its neighbours see nothing else. Sleepers in reach of others let their waves through.
#pragma once

#include "solid_solver/dynamics/step.hpp"

namespace poretwin::solid {

/// After a substep of dt [s] under `drive`: notes what moves, what is calm, what falls asleep and what wakes. Lists and
/// forces follow. Nothing is noted before some soil has flowed, nor unless `solid.quiet.regions` asks for it.
template <int D>
void watch_regions(const Setup<D>& setup, const Drive<D>& drive, double dt, State<D>& state);

/// Everything wakes.
template <int D>
void wake_regions(const Setup<D>& setup, State<D>& state);

}  // namespace poretwin::solid
