// Motion of the pistons in a window: water particles enter and leave through openings.
#pragma once

#include "fluid_solver/boundary/columns.hpp"

namespace poretwin::fluid {

/// Sets the inlets' speeds for the window that begins. The levels in front of the inlets are those of the free water's
/// surface nearby.
template <int D>
void set_inlets(const Setup<D>& setup, const Faces<D>& faces, const Walls<D>& walls, double time, double interval,
                State<D>& state);

/// Throws DivergedError where water flows in although the whole domain is full of water.
template <int D>
void check_room(const Setup<D>& setup, const State<D>& state, double time);

/// Moves the pistons by their speed over an interval [s].
template <int D>
void push_pistons(double interval, State<D>& state) {
  for (auto& inlet : state.inlets) inlet.piston += interval * inlet.speed;
}

/// Adds rows of particles where pistons have moved in, and deletes particles that have followed pistons out.
template <int D>
void serve_inlets(const Setup<D>& setup, State<D>& state);

}  // namespace poretwin::fluid
