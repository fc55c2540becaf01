// Space, divided into one tile for each rank by recursive bisection. The tiles are the same for all phases, so that
// what two solvers exchange mostly stays on one machine.
#pragma once

#include "common/core/vector.hpp"
#include "common/tiles/communicator.hpp"

#include <span>

namespace poretwin::tiles {

/// All x with lower < x <= upper [m] in every direction; empty where there is none.
template <int D>
struct Box {
  Vec<D> lower, upper;
};

/// One tile for each rank. Together they are all of space, and no two of them overlap, so that every point has one
/// owner, also on a face between tiles and beyond the points for which space was cut.
template <int D>
class Partition {
 public:
  /// All of space for rank 0.
  explicit Partition(int ranks);
  explicit Partition(std::vector<Box<D>> tiles) : tiles_(std::move(tiles)) {}

  /// The rank whose tile holds x. `guess` is tried first. Throws DivergedError where x is not a number.
  [[nodiscard]] int owner(const Vec<D>& x, int guess = 0) const;
  /// Owners of all points x [n]; most of them are in tile `guess`.
  [[nodiscard]] std::vector<int> owners(std::span<const Vec<D>> x, int guess) const;
  [[nodiscard]] std::span<const Box<D>> tiles() const { return tiles_; }

 private:
  std::vector<Box<D>> tiles_;  ///< by rank
};

/// Cuts space so that the points of all ranks make about the same load in every tile: along the longest side of what
/// the points occupy into two parts, each of them again, and so on (recursive coordinate bisection, Berger and Bokhari
/// 1987; by Zoltan). Points of several phases may be given together. points [n] [m]: this rank's; load [n]: cost of
/// each point, in any unit, not negative; where all are zero, points count equally. The partition is the same, bit by
/// bit, on every rank. Points that lie on one plane stay together, so that loads are equal only up to such planes.
template <int D>
[[nodiscard]] Partition<D> bisect(const Communicator& all, std::span<const Vec<D>> points,
                                  std::span<const double> load);

/// Largest load of a rank over the mean load of all, minus one: the share of their time for which the others wait. Zero
/// where there is no load.
[[nodiscard]] double imbalance(const Communicator& all, double load);

}  // namespace poretwin::tiles
