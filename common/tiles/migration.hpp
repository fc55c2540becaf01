// Particles go to the rank that owns their place.
#pragma once

#include "common/tiles/communicator.hpp"

#include <Eigen/Core>

#include <concepts>
#include <functional>
#include <span>
#include <type_traits>

namespace poretwin::tiles {

/// Number of a particle in the whole run, the same on whichever rank it is.
using GlobalId = std::uint64_t;

/// Types whose bytes are their value. Eigen's vectors of fixed size are, although they have constructors.
template <class T>
concept Plain = std::is_trivially_copyable_v<T> ||
    (std::derived_from<T, Eigen::PlainObjectBase<T>>&& T::SizeAtCompileTime > 0);

/// The arrays of a rank's particles that go with them, declared once. The arrays must outlive this.
class ParticleArrays {
 public:
  /// An array with `each` entries per particle, those of one particle together.
  template <class T, class Allocator>
  requires Plain<T> ParticleArrays& add(std::vector<T, Allocator>& array, std::size_t each = 1) {
    arrays_.push_back({each * sizeof(T), [&array] { return std::as_writable_bytes(std::span(array)); },
                       [&array, each](std::size_t particles) { array.resize(particles * each); }});
    return *this;
  }
  /// One array of those above: bytes per particle, all bytes, and how its length is set.
  struct Array {
    std::size_t each;
    std::function<std::span<std::byte>()> bytes;
    std::function<void(std::size_t)> resize;
  };
  [[nodiscard]] std::span<const Array> arrays() const { return arrays_; }

 private:
  std::vector<Array> arrays_;
};

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
