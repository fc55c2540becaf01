// Which of the soil's particles and images interact: every pair once.
#pragma once

#include "common/core/threads.hpp"
#include "common/particles/neighbours.hpp"

namespace poretwin::solid {

/// Compressed rows. Row i holds first the real particles with which the interaction is mutual, each pair in one of its
/// two rows; then, from alone[i] on, the nodes that act on i only: images, and particles at rest (fixed or asleep) that
/// are too far from the moving ones to have rows of their own. Both parts are filled up to multiples of four with i
/// itself, which contributes nothing, since loops take four pairs at a time. Rows fall into parts, one for each thread;
/// of a pair across parts each particle has its own copy, which acts on it only.
struct Pairs {
  std::vector<Index> offset{0}, alone;
  std::vector<Index> index;
  std::vector<Index> part{0, 0};  ///< part k has the rows part[k] .. part[k + 1] - 1
  std::vector<char> skipped;      ///< 1 or 0: rows of soil that sleeps among sleeping soil; empty while nothing sleeps
  [[nodiscard]] bool skips(std::size_t i) const { return !skipped.empty() && skipped[i] != 0; }
  [[nodiscard]] std::size_t size() const { return alone.size(); }
  [[nodiscard]] std::size_t n_parts() const { return part.size() - 1; }
};

/// Calls visit(i) for the rows from `first` to `last` - 1 that are not skipped, the parts in parallel.
template <class Visit>
void for_rows(const Pairs& pairs, std::size_t first, std::size_t last, Visit&& visit) {
  for_each_part(pairs.n_parts(), [&](std::size_t part) {
    const std::size_t end = std::min<std::size_t>(last, pairs.part[part + 1]);
    for (std::size_t i = std::max<std::size_t>(first, pairs.part[part]); i < end; ++i)
      if (!pairs.skips(i)) visit(i);
  });
}

/// Calls visit(i, j, m, both) for every pair: particle i, node j, pair m in the list, whether i also acts on j.
template <class Visit>
void for_each_pair(const Pairs& pairs, Visit&& visit) {
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    for (std::size_t m = pairs.offset[i]; m < pairs.alone[i]; ++m)
      if (pairs.index[m] != i) visit(i, std::size_t{pairs.index[m]}, m, true);
    for (std::size_t m = pairs.alone[i]; m < pairs.offset[i + 1]; ++m)
      if (pairs.index[m] != i) visit(i, std::size_t{pairs.index[m]}, m, false);
  }
}

/// Calls visit(i, j, m) for every node j that acts on particle i, m its pair in the list: pairs of real particles are
/// visited in both orders.
template <class Visit>
void for_each_ordered_pair(const Pairs& pairs, Visit&& visit) {
  for_each_pair(pairs, [&](std::size_t i, std::size_t j, std::size_t m, bool both) {
    visit(i, j, m);
    if (both) visit(j, i, m);
  });
}

/// Pairs of the first positions, n_real of them, among themselves and with the images that follow, nearer than range
/// [m]. Of the real ones those from n_free on are held, and the free ones i with asleep[i] sleep (asleep: empty where
/// none does); without others in range the held ones
/// have empty rows, and rows of the sleeping ones are skipped. n_parts: of the rows, of much the same size.
template <int D>
void pair_up(std::span<const Vec<D>> positions, std::size_t n_free, std::size_t n_real, double range,
             std::size_t n_parts, std::span<const char> asleep, Pairs& pairs);

}  // namespace poretwin::solid
