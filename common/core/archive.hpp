// Converts a state to bytes and back. archive(a, b, c) writes its arguments or reads them, depending on how the archive
// was made, so that one piece of code serves both directions. Aggregates are visited member by member and need no code
// of their own; classes with private members have a member `void archive(Archive&)`. Numbers are stored bit by bit.
#pragma once

#include "common/core/error.hpp"
#include "common/core/fields.hpp"

#include <Eigen/Core>

#include <array>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

namespace poretwin {

class Archive;

namespace detail {

template <class T>
concept Fixed = std::is_arithmetic_v<T> || std::is_enum_v<T>;
/// Eigen's matrices and vectors whose size is known at compile time.
template <class T>
concept Tensor = std::derived_from<T, Eigen::PlainObjectBase<T>> && T::SizeAtCompileTime >
0;
template <class T>
concept Visitable = requires(T& x, Archive& archive) {
  x.archive(archive);
};

template <class T>
inline constexpr bool is_array = false;
template <class T, std::size_t n>
inline constexpr bool is_array<std::array<T, n>> = true;

}  // namespace detail

class Archive {
 public:
  /// An empty archive, to which states are written.
  Archive() = default;
  /// An archive that reads the states in `bytes`.
  explicit Archive(std::string bytes) : bytes_(std::move(bytes)), loading_(true) {}

  template <class... T>
  void operator()(T&... x) {
    (visit(x), ...);
  }

  [[nodiscard]] bool loading() const { return loading_; }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }
  /// Throws FileError unless all bytes have been read.
  void expect_end() const {
    if (loading_ && at_ != bytes_.size())
      throw FileError("the saved state holds " + std::to_string(bytes_.size()) + " bytes, " + std::to_string(at_) +
                      " were expected: another program wrote it");
  }

 private:
  void raw(void* data, std::size_t size) {
    if (size == 0) return;
    if (!loading_) {
      bytes_.append(static_cast<const char*>(data), size);
      return;
    }
    need(size, 1);
    std::memcpy(data, bytes_.data() + at_, size);
    at_ += size;
  }

  /// Throws FileError where fewer than count * each bytes are left, before memory for them is allocated.
  void need(std::uint64_t count, std::size_t each) const {
    if (count > (bytes_.size() - at_) / each)
      throw FileError("the saved state ends too early: another program wrote it, or it is damaged");
  }

  template <class Container>
  std::size_t size_of(const Container& x, std::size_t least_each) {
    std::uint64_t size = x.size();
    visit(size);
    if (loading_) need(size, least_each);
    return static_cast<std::size_t>(size);
  }

  template <class T>
  void visit(T& x) {
    if constexpr (detail::Visitable<T>) {
      x.archive(*this);
    } else if constexpr (detail::Fixed<T>) {
      raw(&x, sizeof x);
    } else if constexpr (detail::Tensor<T>) {
      static_assert(sizeof x == sizeof(typename T::Scalar) * T::SizeAtCompileTime);
      raw(x.data(), sizeof(typename T::Scalar) * T::SizeAtCompileTime);
    } else if constexpr (detail::is_array<T>) {
      for (auto& item : x) visit(item);
    } else {
      static_assert(std::is_aggregate_v<T>, "not an aggregate: give it a member archive(Archive&)");
      with_fields(x, *this);
    }
  }

  void visit(std::string& x) {
    x.resize(size_of(x, 1));
    raw(x.data(), x.size());
  }

  template <class T>
  void visit(std::vector<T>& x) {
    static_assert(!std::is_same_v<T, bool>, "use std::vector<char>");
    constexpr bool packed = detail::Fixed<T> || detail::Tensor<T>;
    x.resize(size_of(x, packed ? sizeof(T) : 1));
    if constexpr (packed)
      raw(static_cast<void*>(x.data()), x.size() * sizeof(T));
    else
      for (auto& item : x) visit(item);
  }

  template <class A, class B>
  void visit(std::pair<A, B>& x) {
    (*this)(x.first, x.second);
  }

  template <class Key, class T>
  void visit(std::map<Key, T>& x) {
    const std::size_t size = size_of(x, 1);
    if (!loading_) {
      for (auto& [key, value] : x) {
        Key copy = key;
        (*this)(copy, value);
      }
      return;
    }
    x.clear();
    for (std::size_t k = 0; k < size; ++k) {
      Key key{};
      visit(key);
      visit(x[key]);
    }
  }

  template <class T>
  void visit(std::optional<T>& x) {
    bool there = x.has_value();
    visit(there);
    if (!there) x.reset();
    if (there && !x) x.emplace();
    if (there) visit(*x);
  }

  std::string bytes_;
  std::size_t at_ = 0;
  bool loading_ = false;
};

}  // namespace poretwin
