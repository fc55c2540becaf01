// Soil that several ranks share. Each computes the particles in its tile of space. Copies of those of other ranks that
// its own interact with, its halo, act on its own particles as images do: their rows are on their own rank.
#pragma once

#include "solid_solver/setup.hpp"
#include "solid_solver/state.hpp"

#include <algorithm>
#include <span>

namespace poretwin::solid {

/// Leaves of all particles those with which this rank begins.
template <int D>
void begin_with_share(const Setup<D>& setup, State<D>& state);

/// Sends the particles to the ranks that own their places, and finds the copies that this rank needs. Lists must be
/// made anew afterwards. Does nothing where one rank has all.
template <int D>
void share_out(const Setup<D>& setup, State<D>& state);

/// The whole soil on the rank that leads, as one rank has it, without lists; on the others a soil without particles.
/// Called by all ranks.
template <int D>
State<D> collected(const Setup<D>& setup, const State<D>& state);

/// Calls visit(i) for each of these particles of the whole soil that this rank has, i being its present index.
template <int D, class Visit>
void for_each_own(const Particles<D>& particles, std::span<const Index> of_whole, const Visit& visit) {
  const auto& ids = particles.share.ids;
  const bool has_all = ids.empty() && particles.size() > 0;
  for (const Index id : of_whole) {
    if (has_all) {
      visit(id);
      continue;
    }
    const auto found = std::ranges::lower_bound(ids, GlobalId{id});
    if (found != ids.end() && *found == id) visit(static_cast<Index>(found - ids.begin()));
  }
}

/// Places [m] on all ranks.
template <int D>
VecArray<D> of_all_ranks(const Setup<D>& setup, VecArray<D> places) {
  return setup.tiling ? setup.tiling->gather(places) : places;
}

}  // namespace poretwin::solid
