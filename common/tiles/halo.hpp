// The halo of a rank: copies of the other ranks' particles with which its own may interact.
#pragma once

#include "common/core/vector.hpp"
#include "common/tiles/migration.hpp"
#include "common/tiles/mpi_ranks.hpp"

#include <span>

namespace poretwin::tiles {

/// Finds the halo of every rank: all particles of other ranks within `reach` [m] of any of its own, those of each rank
/// in ascending order of their ids. x [n] [m], ids [n]: this rank's particles. Where lists of pairs are kept while
/// particles move, `reach` is the radius of the search plus the skin; the halo then holds as long as the lists do
/// (lists_outdated()). `shifts`: translations [m] of periodic sides, each in both directions; particles whose shifted
/// place is within reach belong to the halo, too. Images at plane mirrors need no more than that: an image of a
/// particle is never nearer to a point on the inner side than the particle itself. For a point on the outer side,
/// beyond the end of a wall, it may be: `views` are further places [m] around which this rank needs the particles
/// within reach.
template <int D>
[[nodiscard]] HaloPlan find_halo(const Communicator& all, std::span<const Vec<D>> x, std::span<const GlobalId> ids,
                                 double reach, std::span<const Vec<D>> shifts = {}, std::span<const Vec<D>> views = {});

/// Whether any particle of any rank has moved by more than half of `skin` [m] since the lists were made, at the places
/// `at` [n]; x [n]: where this rank's particles are now. Two particles that have both moved by less were within the
/// radius plus the skin of each other then if they are within the radius now.
template <int D>
[[nodiscard]] bool lists_outdated(const Domain& domain, std::span<const Vec<D>> x, std::span<const Vec<D>> at,
                                  double skin) {
  return domain.any_of(x.size(), [&](std::size_t i) { return !(4.0 * (x[i] - at[i]).squaredNorm() <= skin * skin); });
}

}  // namespace poretwin::tiles
