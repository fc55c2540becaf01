// The part of space that one process of a solver computes. A solver may run as several ranks, each with its own
// particles; at present it runs as one. No other code in a solver knows of ranks: exchange() brings values of particles
// that another rank owns, and every sum, maximum or condition over the whole run is evaluated here.
#pragma once

#include "common/core/reductions.hpp"

#include <cmath>
#include <span>
#include <vector>

namespace poretwin {

/// The ranks of one solver, from the point of view of one of them. All ranks call the same functions in the same order,
/// with the same number of values.
class Ranks {
 public:
  virtual ~Ranks() = default;
  /// Replaces each value by its sum, or its maximum, over all ranks. The result is bitwise the same on every rank.
  virtual void sum(std::span<double> values) const = 0;
  virtual void max(std::span<double> values) const = 0;
  /// Fills the numbers of the halo's particles, `each` per particle, which come after those of the owned particles.
  virtual void exchange(std::span<double> values, std::size_t each) const = 0;
};

/// The particles of this rank: its own particles, and the halo, which consists of copies of other ranks' particles with
/// which its own ones interact. In arrays of both, owned particles come first. Functions that take a number of entries
/// or arrays expect only owned ones: a halo particle counts on the rank that owns it.
class Domain {
 public:
  /// One rank, which owns all particles.
  Domain() = default;
  /// One of several ranks. `ranks` must outlive this object.
  Domain(const Ranks& ranks, std::size_t owned, std::size_t halo) : ranks_(&ranks), owned_(owned), halo_(halo) {}

  /// Whether one rank owns all particles, so that there are no copies.
  [[nodiscard]] bool alone() const { return ranks_ == nullptr; }
  /// The same ranks, for sums only: it exchanges nothing.
  [[nodiscard]] Domain of_sums() const { return ranks_ ? Domain(*ranks_, no_particles, 0) : Domain(); }
  /// Number of the halo's particles.
  [[nodiscard]] std::size_t copies() const { return halo_; }

  /// One array holds n numbers for the owned particles. each: its numbers per particle (1 if there is only one rank).
  /// with_halo: its length after the numbers of the halo's particles have been appended.
  [[nodiscard]] std::size_t each(std::size_t n) const { return owned_ == 0 ? 1 : n / owned_; }
  [[nodiscard]] std::size_t with_halo(std::size_t n) const { return n + halo_ * each(n); }
  /// Fills the halo's numbers in an array of owned and halo particles, with `each` numbers per particle.
  void exchange(std::span<double> values, std::size_t each) const {
    if (ranks_ && owned_ != no_particles) ranks_->exchange(values, each);
  }

  /// Sums of this rank's values over all ranks, in place.
  void sum(std::span<double> values) const {
    if (ranks_) ranks_->sum(values);
  }
  [[nodiscard]] double sum(double own) const {
    sum(std::span(&own, 1));
    return own;
  }
  [[nodiscard]] double max(double own) const {
    if (ranks_) ranks_->max(std::span(&own, 1));
    return own;
  }
  [[nodiscard]] double min(double own) const { return -max(-own); }
  /// Maxima of this rank's values over all ranks, in place.
  void max(std::span<double> values) const {
    if (ranks_) ranks_->max(values);
  }
  /// Whether a condition holds on all ranks, or on any rank.
  [[nodiscard]] bool all(bool own) const { return ranks_ ? min(own ? 1.0 : 0.0) > 0.0 : own; }
  [[nodiscard]] bool any(bool own) const { return ranks_ ? max(own ? 1.0 : 0.0) > 0.0 : own; }

  /// Sum of part(i) over all owned entries i of 0 .. n - 1, over all ranks.
  template <class Part>
  [[nodiscard]] double sum_over(std::size_t n, const Part& part) const {
    return sum(one_rank::sum_over(n, part));
  }
  /// Maximum of `least` and all value(i), over all ranks.
  template <class Value>
  [[nodiscard]] double max_over(std::size_t n, double least, const Value& value) const {
    return max(one_rank::max_over(n, least, value));
  }
  /// Whether holds(i) is true for every entry of every rank.
  template <class Holds>
  [[nodiscard]] bool all_of(std::size_t n, const Holds& holds) const {
    return all(parallel_all(n, holds));
  }
  template <class Is>
  [[nodiscard]] bool any_of(std::size_t n, const Is& is) const {
    return !all_of(n, [&](std::size_t i) { return !is(i); });
  }
  /// Scalar product and Euclidean norm of vectors of owned entries.
  [[nodiscard]] double dot(std::span<const double> a, std::span<const double> b) const {
    return sum(one_rank::dot(a, b));
  }
  [[nodiscard]] double norm(std::span<const double> a) const { return std::sqrt(dot(a, a)); }

 private:
  static constexpr std::size_t no_particles = static_cast<std::size_t>(-1);
  const Ranks* ranks_ = nullptr;  ///< null: there is one rank
  std::size_t owned_ = 0, halo_ = 0;
};

/// Brings the entries of the copies, which stand behind those of this rank's own particles, up to date.
template <class T>
void fill_copies(const Domain& domain, std::span<T> values) {
  static_assert(sizeof(T) % sizeof(double) == 0, "values are sent as numbers of 8 bytes");
  constexpr std::size_t each = sizeof(T) / sizeof(double);
  domain.exchange({reinterpret_cast<double*>(values.data()), values.size() * each}, each);
}

/// A field of this rank's own particles, followed by the entries of the copies, up to date. On one rank it is the field
/// itself, which must outlive this.
template <class T>
class WithCopies {
 public:
  WithCopies(const Domain& domain, std::span<const T> own) : all_(own) {
    if (domain.alone()) return;
    values_.assign(own.begin(), own.end());
    values_.resize(own.size() + domain.copies());
    fill_copies(domain, std::span<T>(values_));
    all_ = values_;
  }
  WithCopies(const WithCopies&) = delete;
  WithCopies(WithCopies&&) noexcept = default;
  WithCopies& operator=(const WithCopies&) = delete;
  WithCopies& operator=(WithCopies&&) noexcept = default;
  operator std::span<const T>() const { return all_; }  // NOLINT: it takes the field's place
  [[nodiscard]] const T& operator[](std::size_t i) const { return all_[i]; }
  [[nodiscard]] bool empty() const { return all_.empty(); }

 private:
  std::vector<T> values_;
  std::span<const T> all_;
};

}  // namespace poretwin
