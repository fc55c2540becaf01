// Loops over pairs, four at a time, with one thread for each part of the rows. Loop bodies capture plain pointers by
// value: the compiler assumes that vector stores may change whatever is captured by reference, and would read it again.
#pragma once

#include "common/core/lanes.hpp"
#include "solid_solver/state.hpp"

#include <algorithm>
#include <type_traits>

namespace poretwin::solid {

/// Pointers into a pair list, to be captured by value.
struct PairView {
  const Index *offset, *alone, *index;
  std::size_t size;
  explicit PairView(const Pairs& pairs)
      : offset(pairs.offset.data()), alone(pairs.alone.data()), index(pairs.index.data()), size(pairs.index.size()) {}
};

/// Prefetches the packed nodes of four pairs 64 entries after m: of each node the cache lines (64 bytes) `first` to
/// `last` - 1.
template <std::size_t first, std::size_t last, class Packed>
[[gnu::always_inline]] inline void fetch_ahead(const PairView& pairs, const Packed* all, std::size_t m) {
  constexpr std::size_t ahead = 64, line = 64;
  const Index* const index = &pairs.index[std::min(m + ahead, pairs.size - n_lanes)];
  for (std::size_t l = 0; l < n_lanes; ++l)
    for (std::size_t k = first; k < last; ++k)
      __builtin_prefetch(reinterpret_cast<const char*>(&all[index[l]]) + k * line);
}

/// Calls loop(std::true_type{}) where n_packed nodes exceed a core's caches, so that prefetching saves time, otherwise
/// loop(std::false_type{}).
template <class Loop>
void fetching_if_many(std::size_t n_packed, const Loop& loop) {
  constexpr std::size_t many = 16384;
  if (n_packed > many)
    loop(std::true_type{});
  else
    loop(std::false_type{});
}

/// Calls visit(i) for the rows from `first` to `last` - 1, skipped ones included, compiled for this machine's vector
/// instructions. visit must be marked always_inline.
template <class Visit>
void for_all_rows_in_lanes(const Pairs& pairs, std::size_t first, std::size_t last, const Visit& visit) {
  for_each_part(pairs.n_parts(), [&](std::size_t part) {
    const std::size_t begin = std::max<std::size_t>(first, pairs.part[part]);
    const std::size_t end = std::min<std::size_t>(last, pairs.part[part + 1]);
    run_lanes([=]() __attribute__((always_inline)) {
      const Visit here = visit;
      for (std::size_t i = begin; i < end; ++i) here(i);
    });
  });
}

/// Calls visit(i) in the same way for the rows that are not skipped.
template <class Visit>
void for_rows_in_lanes(const Pairs& pairs, std::size_t first, std::size_t last, const Visit& visit) {
  const char* const skipped = pairs.skipped.empty() ? nullptr : pairs.skipped.data();
  for_all_rows_in_lanes(
      pairs, first, last, [=](std::size_t i) __attribute__((always_inline)) {
        if (skipped == nullptr || skipped[i] == 0) visit(i);
      });
}

/// Calls visit(m, both) for the pairs of row i, four pairs from m on at a time. both: the pairs act on both of their
/// particles.
template <class Visit>
[[gnu::always_inline]] inline void for_four_pairs(const PairView& pairs, std::size_t i, Visit&& visit) {
  const std::size_t alone = pairs.alone[i], end = pairs.offset[i + 1];
  for (std::size_t m = pairs.offset[i]; m < alone; m += n_lanes) visit(m, true);
  for (std::size_t m = alone; m < end; m += n_lanes) visit(m, false);
}

/// The packed data of four particles or images.
template <class Packed>
[[gnu::always_inline]] inline FourRows<const double> rows_at(const Packed* all, const Index* index) {
  return {all[index[0]].row(), all[index[1]].row(), all[index[2]].row(), all[index[3]].row()};
}

/// The sums of four particles, to be added to.
template <std::size_t n>
[[gnu::always_inline]] inline FourRows<double> sums_at(Sums<n>* sums, const Index* index) {
  return {sums[index[0]].x.data(), sums[index[1]].x.data(), sums[index[2]].x.data(), sums[index[3]].x.data()};
}

}  // namespace poretwin::solid
