#include "solid_solver/pairs.hpp"

#include "common/core/lanes.hpp"

namespace poretwin::solid {
namespace {

/// Rows of one part; offsets count from its own beginning.
struct Rows {
  std::vector<Index> offset, alone, index;
  Index fill_up(std::size_t i) {
    while (index.size() % n_lanes != 0) index.push_back(static_cast<Index>(i));
    return static_cast<Index>(index.size());
  }
};

/// Held particles that have soil in range.
std::vector<char> reached(const std::vector<Rows>& parts, std::size_t n_free, std::size_t n_real) {
  std::vector<char> near(n_real, 0);
  for (const auto& rows : parts)
    for (const Index j : rows.index)
      if (j >= n_free && j < n_real) near[j] = 1;
  return near;
}

void append(const std::vector<Rows>& parts, Pairs& pairs) {
  for (const auto& rows : parts) {
    const auto begin = static_cast<Index>(pairs.index.size());
    pairs.index.insert(pairs.index.end(), rows.index.begin(), rows.index.end());
    for (const Index m : rows.alone) pairs.alone.push_back(begin + m);
    for (const Index m : rows.offset) pairs.offset.push_back(begin + m);
  }
}

}  // namespace

template <int D>
void pair_up(std::span<const Vec<D>> positions, std::size_t n_free, std::size_t n_real, double range,
             std::size_t n_parts, Pairs& pairs) {
  sph::CellGrid<D> particles, images;
  particles.build(positions.first(n_real), range);
  images.build(positions.subspan(n_real), range);
  pairs.offset.assign(1, 0);
  pairs.alone.clear();
  pairs.index.clear();
  pairs.part.clear();
  for (std::size_t k = 0; k <= n_parts; ++k) pairs.part.push_back(static_cast<Index>(n_real * k / n_parts));
  auto append_images = [&](std::size_t i, std::vector<Index>& index) {
    const std::size_t begin = index.size();
    images.append_within(positions[i], range, 0, index);
    for (std::size_t m = begin; m < index.size(); ++m) index[m] += static_cast<Index>(n_real);
  };
  std::vector<Rows> free(n_parts), held(n_parts);
  for_each_part(n_parts, [&](std::size_t part) {
    Rows& rows = free[part];
    const Index first = pairs.part[part], last = pairs.part[part + 1];
    std::vector<Index> around;
    for (std::size_t i = first; i < std::min<std::size_t>(last, n_free); ++i) {
      if (n_parts == 1) {
        particles.append_within(positions[i], range, static_cast<Index>(i + 1), rows.index);
        rows.alone.push_back(rows.fill_up(i));
      } else {
        around.clear();
        particles.append_within(positions[i], range, 0, around);
        for (const Index j : around)
          if (j > i && j < last) rows.index.push_back(j);
        rows.alone.push_back(rows.fill_up(i));
        for (const Index j : around)
          if (j < first || j >= last) rows.index.push_back(j);
      }
      append_images(i, rows.index);
      rows.offset.push_back(rows.fill_up(i));
    }
  });
  const std::vector<char> near = reached(free, n_free, n_real);
  for_each_part(n_parts, [&](std::size_t part) {
    Rows& rows = held[part];
    const Index first = pairs.part[part], last = pairs.part[part + 1];
    std::vector<Index> around;
    for (std::size_t i = std::max<std::size_t>(first, n_free); i < last; ++i) {
      around.clear();
      if (near[i]) particles.append_within(positions[i], range, n_parts == 1 ? static_cast<Index>(n_free) : 0, around);
      auto shared = [&](Index j) { return j >= first && j < last && (j < n_free || near[j]); };
      for (const Index j : around)
        if (j > i && shared(j)) rows.index.push_back(j);
      rows.alone.push_back(rows.fill_up(i));
      if (near[i]) append_images(i, rows.index);
      for (const Index j : around)
        if (!shared(j)) rows.index.push_back(j);
      rows.offset.push_back(rows.fill_up(i));
    }
  });
  append(free, pairs);
  append(held, pairs);
}

template void pair_up<2>(std::span<const Vec<2>>, std::size_t, std::size_t, double, std::size_t, Pairs&);
template void pair_up<3>(std::span<const Vec<3>>, std::size_t, std::size_t, double, std::size_t, Pairs&);

}  // namespace poretwin::solid
