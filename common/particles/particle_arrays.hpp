// The arrays of a solver's particles, declared once, so that particles can change their places and their ranks.
#pragma once

#include "common/core/vector.hpp"

#include <Eigen/Core>

#include <concepts>
#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <type_traits>
#include <vector>

namespace poretwin {

/// Number of a particle in the whole run, the same on whichever rank it is.
using GlobalId = std::uint64_t;

/// Types whose bytes are their value. Eigen's vectors of fixed size are, although they have constructors, and so are
/// the packed numbers of a point (for_pairs.hpp).
template <class T>
concept Plain = std::is_trivially_copyable_v<T> ||
                (std::derived_from<T, Eigen::PlainObjectBase<T>>&& T::SizeAtCompileTime > 0) ||
                requires(const T& x) {
  { x.row() } -> std::same_as<const double*>;
};

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

  /// Particle i becomes the one that was order[i]; the arrays have as many particles afterwards as `order`.
  void reorder(std::span<const Index> order) const {
    std::vector<std::byte> old;
    for (const Array& array : arrays_) {
      const auto before = array.bytes();
      old.assign(before.begin(), before.end());
      array.resize(order.size());
      for (std::size_t i = 0; i < order.size(); ++i)
        std::memcpy(array.bytes().data() + i * array.each, old.data() + order[i] * array.each, array.each);
    }
  }

 private:
  std::vector<Array> arrays_;
};

}  // namespace poretwin
