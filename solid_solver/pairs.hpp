// Who feels whom among the soil's particles and images: every pair once.
#pragma once

#include "common/sph/neighbours.hpp"

namespace poretwin::solid {

/// Compressed rows. Row i holds first the real particles j > i (the pair is felt by both), then from alone[i] on those
/// that i feels without being felt: images, and held particles too far from the soil to take part.
struct Pairs {
  std::vector<Index> offset{0}, alone;
  std::vector<Index> index;
  [[nodiscard]] std::size_t size() const { return alone.size(); }
};

/// Calls visit(i, j, m, both) for every pair: particle i, node j, pair m in the list, whether j feels i, too.
template <class Visit>
void for_each_pair(const Pairs& pairs, Visit&& visit) {
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    for (std::size_t m = pairs.offset[i]; m < pairs.alone[i]; ++m) visit(i, std::size_t{pairs.index[m]}, m, true);
    for (std::size_t m = pairs.alone[i]; m < pairs.offset[i + 1]; ++m) visit(i, std::size_t{pairs.index[m]}, m, false);
  }
}

/// Calls feel(i, j, m) for whatever particle i feels of node j, pair m in the list: twice for pairs of real particles.
template <class Feel>
void for_each_felt(const Pairs& pairs, Feel&& feel) {
  for_each_pair(pairs, [&](std::size_t i, std::size_t j, std::size_t m, bool both) {
    feel(i, j, m);
    if (both) feel(j, i, m);
  });
}

/// Pairs of the first positions, n_real of them, among themselves and with the images that follow, nearer than range
/// [m]. Of the real ones those from n_free on are held; held particles without soil in range have empty rows.
template <int D>
void pair_up(std::span<const Vec<D>> positions, std::size_t n_free, std::size_t n_real, double range, Pairs& pairs);

}  // namespace poretwin::solid
