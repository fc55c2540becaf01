// Arrays of what most scenes have none of.
#pragma once

#include "common/core/archive.hpp"

#include <type_traits>
#include <vector>

namespace poretwin {

/// Values that are zero everywhere, and take no memory, until they are laid out.
template <class T>
class OrZero {
 public:
  OrZero() = default;
  OrZero(std::vector<T> values) : values_(std::move(values)) {}  // NOLINT: an array is one of these
  [[nodiscard]] bool is_laid_out() const { return !values_.empty(); }
  void lay_out(std::size_t n) { values_.assign(n, zero()); }
  void set(std::size_t a, const T& value) { values_[a] = value; }
  /// The same, of n, laid out if they are not yet.
  void set(std::size_t a, const T& value, std::size_t n) {
    if (!is_laid_out()) lay_out(n);
    set(a, value);
  }
  [[nodiscard]] const T& operator[](std::size_t a) const { return values_.empty() ? zero() : values_[a]; }
  [[nodiscard]] auto begin() const { return values_.begin(); }
  [[nodiscard]] auto end() const { return values_.end(); }
  /// One more, a zero.
  void grow() {
    if (is_laid_out()) values_.push_back(zero());
  }
  /// All of them where they are laid out, else none.
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
