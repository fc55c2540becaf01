// Regions at rest around soil that flows: they sleep, and wake when something changes.
//
// What rests has neither yielded nor moved for a while: waves pass through it to and fro without end, so that not its
// velocity tells but how far it has come. It is then calm and damped near-critically, which lets those waves die out,
// and falls asleep if it stays calm and so does all around it. Asleep it has stress and volume as they were, and no
// strain; that is all that its neighbours feel of it. Sleepers in reach of others let their waves through.
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
