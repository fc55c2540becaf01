// Particles go to the rank that owns their place.
#pragma once

#include "common/particles/particle_arrays.hpp"
#include "common/tiles/communicator.hpp"

#include <span>

namespace poretwin::tiles {

/// How many particles left this rank and came to it.
struct Migrated {
  std::size_t left = 0, came = 0;
};

/// Sends every particle of this rank to its owner [ranks' particles], with its id and its entries in all arrays.
/// Afterwards the particles of each rank stand in ascending order of their ids: the order does not depend on the way
/// they took. Throws where arrays do not fit the particles, where a rank has two particles of one id, and where the
/// particles of all ranks are not the same as before.
Migrated migrate(const Communicator& all, std::span<const int> owner, std::vector<GlobalId>& ids,
                 const ParticleArrays& arrays);

}  // namespace poretwin::tiles
