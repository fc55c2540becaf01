// Tests that every rank of an MPI run executes: each EXPECT counts on the rank that meets it, and the run fails where
// any does. No ASSERT: a rank that left a test early would leave the others waiting.
#pragma once

#include "common/tiles/communicator.hpp"
#include "common/tiles/partition.hpp"

#include "common/core/vector.hpp"

#include <limits>
#include <random>

namespace poretwin::tiles {

/// All ranks of this run; set by main().
const Communicator& all_ranks();

/// Slabs of equal thickness across an axis, of which the first and the last are open.
template <int D>
Partition<D> slabs(int axis, double from, double to) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const int n = all_ranks().size();
  std::vector<Box<D>> boxes(static_cast<std::size_t>(n), {Vec<D>::Constant(-infinity), Vec<D>::Constant(infinity)});
  for (int r = 0; r + 1 < n; ++r)
    boxes[static_cast<std::size_t>(r)].upper[axis] = boxes[static_cast<std::size_t>(r) + 1].lower[axis] =
        from + (to - from) * (r + 1) / n;
  return Partition<D>(std::move(boxes));
}

/// Particles as every rank can make them by itself, in the order of their ids 0 .. n - 1: a lattice in the unit square
/// or cube, each point off its place by up to a fifth of the spacing.
template <int D>
VecArray<D> scattered(std::size_t side, unsigned seed = 1) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> off(-0.2, 0.2);
  const double dx = 1.0 / static_cast<double>(side);
  std::size_t n = 1;
  for (int d = 0; d < D; ++d) n *= side;
  VecArray<D> x(n);
  for (std::size_t i = 0; i < n; ++i) {
    std::size_t rest = i;
    for (int d = 0; d < D; ++d) {
      x[i][d] = (static_cast<double>(rest % side) + 0.5 + off(generator)) * dx;
      rest /= side;
    }
  }
  return x;
}

}  // namespace poretwin::tiles
