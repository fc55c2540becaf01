// Space divided among the ranks of a solver, as the solver sees it.
#pragma once

#include "common/particles/domain.hpp"
#include "common/particles/particle_arrays.hpp"

#include <string>

namespace poretwin {

/// One tile of space for each rank, which owns the particles in it. All ranks call the same functions in the same
/// order.
template <int D>
class Tiling {
 public:
  virtual ~Tiling() = default;
  /// The ranks. Their exchange fills the copies that find_copies() found last.
  [[nodiscard]] virtual const Ranks& ranks() const = 0;
  /// Whether this rank begins with a particle, before particles are sent to their owners.
  [[nodiscard]] virtual bool begins_with(GlobalId id) const = 0;
  /// Sends every particle of this rank, with its id and its entries in all arrays, to the rank in whose tile its place
  /// lies: x [n] [m], one of the arrays. Space is cut anew where the loads have become too unequal. Afterwards the
  /// particles of each rank stand in ascending order of their ids.
  virtual void send_to_owners(const VecArray<D>& x, std::vector<GlobalId>& ids, const ParticleArrays& arrays) = 0;
  /// Finds the particles of other ranks within `reach` [m] of this rank's own, at x [n] [m], or of the further places
  /// `views` [m]. Returns how many there are; their copies stand behind the owned particles.
  [[nodiscard]] virtual std::size_t find_copies(const VecArray<D>& x, std::span<const GlobalId> ids, double reach,
                                                std::span<const Vec<D>> views) = 0;
  /// The places [m] that all ranks name, in the order of the ranks.
  [[nodiscard]] virtual VecArray<D> gather(const VecArray<D>& places) const = 0;
  /// The numbers that all ranks give, in the order of the ranks.
  [[nodiscard]] virtual ScalarArray gather_numbers(const ScalarArray& numbers) const = 0;
  /// Whether this rank is the one that leads: it reads and writes files, and is asked for results.
  [[nodiscard]] virtual bool leads() const = 0;
  /// Sends all particles, with their ids and their entries in all arrays, to the rank that leads, where they stand in
  /// ascending order of their ids; the others have none afterwards.
  virtual void send_to_leader(std::vector<GlobalId>& ids, const ParticleArrays& arrays) const = 0;
  /// On every rank the bytes that the rank that leads gives.
  [[nodiscard]] virtual std::string from_leader(const std::string& bytes) const = 0;
};

}  // namespace poretwin
