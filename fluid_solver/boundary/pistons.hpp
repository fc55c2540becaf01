// What pistons do in a window: particles of water come and go through openings.
#pragma once

#include "fluid_solver/boundary/columns.hpp"

namespace poretwin::fluid {

/// What the inlets do in the window that begins: the levels before them from the free water's surface near by.
template <int D>
void set_inlets(const Setup<D>& setup, const Faces<D>& faces, double time, double interval, State<D>& state);

/// Throws where inflow meets walls that are already full of water.
template <int D>
void check_room(const State<D>& state, double time);

/// Moves the pistons by their speed over an interval [s].
template <int D>
void push_pistons(double interval, State<D>& state) {
  for (auto& inlet : state.inlets) inlet.piston += interval * inlet.speed;
}

/// Rows for what pistons pushed in, and water taken away that has followed them out.
template <int D>
void serve_inlets(const Setup<D>& setup, State<D>& state);

}  // namespace poretwin::fluid
