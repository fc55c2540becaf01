// Arrays that are written before they are read.
#pragma once

#include <memory>
#include <utility>
#include <vector>

namespace poretwin {

/// What leaves numbers as they are found where nothing is said of them.
template <class T>
struct Unset : std::allocator<T> {
  template <class Other>
  struct rebind {
    using other = Unset<Other>;
  };
  template <class Value>
  void construct(Value* at) noexcept {
    ::new (static_cast<void*>(at)) Value;
  }
  template <class Value, class... From>
  void construct(Value* at, From&&... from) {
    std::construct_at(at, std::forward<From>(from)...);
  }
};

/// An array whose numbers are not set to zero as it grows.
template <class T>
using UnsetArray = std::vector<T, Unset<T>>;

}  // namespace poretwin
