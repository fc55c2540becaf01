// The part of space that one process of a solver computes. A solver may run as several ranks, each with its own
// particles; today there is one. Nothing else in a solver knows of ranks: values of particles that another rank owns
// come by exchange(), and whatever decides about the whole run is a sum, a maximum or a question to all, asked here.
#pragma once

#include "common/core/reductions.hpp"

#include <cmath>
#include <span>

namespace poretwin {

/// The ranks of one solver, as one of them sees them. All ranks call the same functions in the same order, with as many
/// values.
class Ranks {
 public:
  virtual ~Ranks() = default;
  /// Replaces each value by its sum, or its maximum, over all ranks; the result has the same bits on every rank.
  virtual void sum(std::span<double> values) const = 0;
  virtual void max(std::span<double> values) const = 0;
  /// Fills the numbers of the halo's particles, `each` per particle, which lie behind those of the owned ones.
  virtual void exchange(std::span<double> values, std::size_t each) const = 0;
};

/// The particles of this rank: those that it owns, and the halo, copies of other ranks' particles that owned ones
/// interact with. In arrays of both, owned particles come first. Functions that take a number of entries or arrays
/// expect owned ones only: the halo counts on the rank that owns it.
class Domain {
 public:
  /// One rank, which owns everything.
  Domain() = default;
  /// One of several ranks; `ranks` must outlive this.
  Domain(const Ranks& ranks, std::size_t owned, std::size_t halo) : ranks_(&ranks), owned_(owned), halo_(halo) {}

  /// Of an array with n numbers of owned particles: how many of them each particle has (where there is a halo), and the
  /// array's length with the halo.
  [[nodiscard]] std::size_t each(std::size_t n) const { return owned_ == 0 ? 1 : n / owned_; }
  [[nodiscard]] std::size_t with_halo(std::size_t n) const { return n + halo_ * each(n); }
  /// Fills the halo's numbers in an array of owned and halo particles; `each` per particle.
  void exchange(std::span<double> values, std::size_t each) const {
    if (ranks_) ranks_->exchange(values, each);
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
  /// Whether something is true on all ranks, or on any.
  [[nodiscard]] bool all(bool own) const { return ranks_ ? min(own ? 1.0 : 0.0) > 0.0 : own; }
  [[nodiscard]] bool any(bool own) const { return ranks_ ? max(own ? 1.0 : 0.0) > 0.0 : own; }

  /// Sum of part(i) over all owned entries i of 0 .. n - 1, of every rank.
  template <class Part>
  [[nodiscard]] double sum_over(std::size_t n, const Part& part) const {
    return sum(one_rank::sum_over(n, part));
  }
  /// Maximum of `least` and all value(i).
  template <class Value>
  [[nodiscard]] double max_over(std::size_t n, double least, const Value& value) const {
    return max(one_rank::max_over(n, least, value));
  }
  /// Whether holds(i) is true for every entry.
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
  const Ranks* ranks_ = nullptr;  ///< none: one rank
  std::size_t owned_ = 0, halo_ = 0;
};

}  // namespace poretwin
