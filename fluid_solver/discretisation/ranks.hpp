// Water that several ranks share. Each computes the particles in its tile of space. Copies of those of other ranks that
// its own interact with, its halo, stand behind its own particles in the stencil: they have no rows of pairs.
#pragma once

#include "fluid_solver/boundary/walls.hpp"
#include "fluid_solver/state.hpp"

#include <algorithm>
#include <array>

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
/// The same for what lies within `reach` [m] of a particle or of its images in these planes.
template <int D>
[[nodiscard]] Domain with_halo(const Setup<D>& setup, std::span<const sph::ImagePlane<D>> planes, const Particles<D>& p,
                               double reach);

/// Adds a particle with these properties (Particles::add) to the whole water. All ranks call this, and one of them
/// takes the particle.
template <int D, class... Properties>
void add_particle(const Setup<D>& setup, Particles<D>& p, const Properties&... properties) {
  if (setup.tiling) {
    const GlobalId id = p.share.next++;
    if (!setup.tiling->begins_with(id)) return;
    p.share.ids.push_back(id);
  }
  p.add(properties...);
}

/// Id of particle a of this rank. Ids ascend, on all ranks together, in the order in which one rank has the particles.
template <int D>
[[nodiscard]] GlobalId id_of(const Particles<D>& p, std::size_t a) {
  return p.share.ids.empty() ? a : p.share.ids[a];
}

/// The records of all ranks in ascending order, which the entries of each determine from the first on. All ranks call
/// this.
template <int D, std::size_t n>
[[nodiscard]] std::vector<std::array<double, n>> from_all_ranks(const Setup<D>& setup,
                                                                std::vector<std::array<double, n>> own) {
  if (setup.tiling) {
    ScalarArray numbers;
    for (const auto& record : own) numbers.insert(numbers.end(), record.begin(), record.end());
    numbers = setup.tiling->gather_numbers(numbers);
    own.resize(numbers.size() / n);
    for (std::size_t i = 0; i < numbers.size(); ++i) own[i / n][i % n] = numbers[i];
  }
  std::ranges::sort(own);
  return own;
}

/// The whole water on the rank that leads, as one rank has it; on the others water without particles. Called by all
/// ranks.
template <int D>
[[nodiscard]] State<D> collected(const Setup<D>& setup, const State<D>& state);

}  // namespace poretwin::fluid
