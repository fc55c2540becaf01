// Arrays for quantities that are zero in most cases.
#pragma once

#include "common/core/archive.hpp"

#include <type_traits>
#include <vector>

namespace poretwin {

/// An array whose entries are zero, without using memory, until it is allocated.
template <class T>
class OrZero {
 public:
  OrZero() = default;
  OrZero(std::vector<T> values) : values_(std::move(values)) {}  // NOLINT: a plain array converts to this type
  [[nodiscard]] bool is_allocated() const { return !values_.empty(); }
  void allocate(std::size_t n) { values_.assign(n, zero()); }
  void set(std::size_t a, const T& value) { values_[a] = value; }
  /// Sets an element of an array with n elements. Allocates the array first if necessary.
  void set(std::size_t a, const T& value, std::size_t n) {
    if (!is_allocated()) allocate(n);
    set(a, value);
  }
  [[nodiscard]] const T& operator[](std::size_t a) const { return values_.empty() ? zero() : values_[a]; }
  [[nodiscard]] auto begin() const { return values_.begin(); }
  [[nodiscard]] auto end() const { return values_.end(); }
  /// Appends a zero; does nothing while the array is not allocated.
  void grow() {
    if (is_allocated()) values_.push_back(zero());
  }
  /// The n values; empty while the array is not allocated.
  [[nodiscard]] std::vector<T>& values() { return values_; }
  [[nodiscard]] const std::vector<T>& values() const { return values_; }
  void archive(Archive& archive) { archive(values_); }

 private:
  static const T& zero() {
    static const T value = [] {
      if constexpr (std::is_arithmetic_v<T>)
        return T{};
      else
        return T(T::Zero());
    }();
    return value;
  }
  std::vector<T> values_;
};

}  // namespace poretwin
