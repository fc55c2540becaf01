// Water that several ranks share. Each computes the particles in its tile of space. Copies of those of other ranks that
// its own interact with, its halo, stand behind its own particles in the stencil: they have no rows of pairs.
#pragma once

#include "fluid_solver/boundary/walls.hpp"
#include "fluid_solver/state.hpp"

namespace poretwin::fluid {

/// Leaves of all particles those of this rank, each on the rank that owns its place. Does nothing where one rank has
/// all, as share_out() and with_halo() do.
template <int D>
void begin_with_share(const Setup<D>& setup, Particles<D>& p);

/// Sends the particles to the ranks that own their places; all ranks call this. Stencils must be made anew afterwards.
template <int D>
void share_out(const Setup<D>& setup, Particles<D>& p);

/// The particles of this rank, and the copies that it needs at the present places of all particles; all ranks call
/// this. It holds until the next call.
template <int D>
[[nodiscard]] Domain with_halo(const Setup<D>& setup, const Walls<D>& walls, const Particles<D>& p);

/// The whole water on the rank that leads, as one rank has it; on the others water without particles. Called by all
/// ranks.
template <int D>
[[nodiscard]] State<D> collected(const Setup<D>& setup, const State<D>& state);

}  // namespace poretwin::fluid
