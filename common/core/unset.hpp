// Arrays whose elements are not initialised, for values that are written before they are read.
#pragma once

#include <memory>
#include <utility>
#include <vector>

namespace poretwin {

/// Allocator that leaves numbers uninitialised if no value is given.
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

/// An array whose new elements are not set to zero.
template <class T>
using UnsetArray = std::vector<T, Unset<T>>;

}  // namespace poretwin
