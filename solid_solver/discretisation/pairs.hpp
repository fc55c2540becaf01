// Pairs of the soil's particles and images that interact. Each pair is listed once.
#pragma once

#include "common/core/threads.hpp"
#include "common/particles/for_pairs.hpp"
#include "common/particles/neighbours.hpp"

namespace poretwin::solid {

/// Pair lists as compressed rows. Row i begins with the real particles with which the interaction is mutual; each such
/// pair is in only one of its two rows. Entries from alone[i] on are the nodes that act on i only: images, copies of
/// other ranks' particles (their ranks compute how i acts on them), and particles at rest (fixed or asleep) that are
/// too far from the moving ones to have rows of their own. Both parts are padded to multiples of four with i itself,
/// which contributes nothing, since loops take four pairs at a time.
///
/// The rows are divided into parts, one for each thread. A pair of two parts is stored in both, and each copy acts only
/// on the particle of its own part.
struct Pairs {
  std::vector<Index> offset{0}, alone;
  std::vector<Index> index;
  std::vector<Index> part{0, 0};  ///< part k consists of the rows part[k] .. part[k + 1] - 1
  std::vector<char> skipped;      ///< 1 for rows of sleeping soil among sleeping soil, else 0; empty while no soil
                                  ///< sleeps
  [[nodiscard]] bool skips(std::size_t i) const { return !skipped.empty() && skipped[i] != 0; }
  [[nodiscard]] std::size_t size() const { return alone.size(); }
  [[nodiscard]] std::size_t n_parts() const { return part.size() - 1; }
  /// The rows from `first` to `last` - 1 for for_pairs(): all of them (all_rows), or those that are not skipped (rows).
  [[nodiscard]] HalfRows all_rows(std::size_t first, std::size_t last) const {
    return {offset.data(), alone.data(), index.data(), part, index.size(), first, last, nullptr};
  }
  [[nodiscard]] HalfRows rows(std::size_t first, std::size_t last) const {
    HalfRows wanted = all_rows(first, last);
    if (!skipped.empty()) wanted.skipped = skipped.data();
    return wanted;
  }
};

/// Which particles have images in their rows, in the order of the images: the views of image k are view[offset[k]] ..
/// view[offset[k + 1] - 1]. The images of one parent are consecutive: those of parent p are first[p] .. first[p + 1] -
/// 1, where p counts only particles that have images. Empty where images are symmetric in pairs, as behind planes.
struct Views {
  struct View {
    Index row, pair;  ///< particle, and index of the pair in the list
  };
  std::vector<Index> offset, first;
  std::vector<View> view;
};

/// Lists the views of images whose parents are given, in ascending order.
void list_views(const Pairs& pairs, std::span<const Index> parents, Views& views);

/// Calls visit(i) for the rows from `first` to `last` - 1 that are not skipped, with the parts in parallel.
template <class Visit>
void for_rows(const Pairs& pairs, std::size_t first, std::size_t last, Visit&& visit) {
  for_each_part(pairs.n_parts(), [&](std::size_t part) {
    const std::size_t end = std::min<std::size_t>(last, pairs.part[part + 1]);
    for (std::size_t i = std::max<std::size_t>(first, pairs.part[part]); i < end; ++i)
      if (!pairs.skips(i)) visit(i);
  });
}

/// Calls visit(i, j, m, both) for every pair: particle i, node j, index m of the pair in the list. both: whether i also
/// acts on j.
template <class Visit>
void for_each_pair(const Pairs& pairs, Visit&& visit) {
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    for (std::size_t m = pairs.offset[i]; m < pairs.alone[i]; ++m)
      if (pairs.index[m] != i) visit(i, std::size_t{pairs.index[m]}, m, true);
    for (std::size_t m = pairs.alone[i]; m < pairs.offset[i + 1]; ++m)
      if (pairs.index[m] != i) visit(i, std::size_t{pairs.index[m]}, m, false);
  }
}

/// Calls visit(i, j, m) for every node j that acts on particle i; m: index of their pair in the list. Pairs of real
/// particles are visited in both orders.
template <class Visit>
void for_each_ordered_pair(const Pairs& pairs, Visit&& visit) {
  for_each_pair(pairs, [&](std::size_t i, std::size_t j, std::size_t m, bool both) {
    visit(i, j, m);
    if (both) visit(j, i, m);
  });
}

/// Lists the pairs closer than range [m]: pairs among the first n_real positions, which are particles, and pairs of
/// these with the rest, which are copies of other ranks' particles and then images. copies_at_rest: for each copy 1
/// where it is of a fixed or sleeping particle. Particles from n_free on are fixed. A free particle i sleeps where
/// asleep[i] != 0 (asleep is empty if none sleeps). If no moving particle is within range, the row of a fixed particle
/// is empty, and that of a sleeping one is marked as skipped. The rows are divided into n_parts parts of similar work.
/// originals: if not empty, the particle of each image, which is seen only from this particle's side of the plane
/// midway.
template <int D>
void pair_up(std::span<const Vec<D>> positions, std::size_t n_free, std::size_t n_real, double range,
             std::size_t n_parts, std::span<const char> asleep, std::span<const Index> originals, Pairs& pairs,
             std::span<const char> copies_at_rest = {});

}  // namespace poretwin::solid
