#include "solid_solver/pairs.hpp"

namespace poretwin::solid {
namespace {

/// Held particles that have soil in range.
std::vector<char> reached(const Pairs& pairs, std::size_t n_free, std::size_t n_real) {
  std::vector<char> near(n_real, 0);
  for (const Index j : pairs.index)
    if (j >= n_free && j < n_real) near[j] = 1;
  return near;
}

}  // namespace

template <int D>
void pair_up(std::span<const Vec<D>> positions, std::size_t n_free, std::size_t n_real, double range, Pairs& pairs) {
  sph::CellGrid<D> particles, images;
  particles.build(positions.first(n_real), range);
  images.build(positions.subspan(n_real), range);
  pairs.offset.assign(1, 0);
  pairs.alone.clear();
  pairs.index.clear();
  auto close_row = [&](std::size_t i, bool feels_images) {
    pairs.alone.push_back(static_cast<Index>(pairs.index.size()));
    if (feels_images) {
      const std::size_t begin = pairs.index.size();
      images.append_within(positions[i], range, 0, pairs.index);
      for (std::size_t m = begin; m < pairs.index.size(); ++m) pairs.index[m] += static_cast<Index>(n_real);
    }
    pairs.offset.push_back(static_cast<Index>(pairs.index.size()));
  };
  for (std::size_t i = 0; i < n_free; ++i) {
    particles.append_within(positions[i], range, static_cast<Index>(i + 1), pairs.index);
    close_row(i, true);
  }
  const std::vector<char> near = reached(pairs, n_free, n_real);
  std::vector<Index> around;
  for (std::size_t i = n_free; i < n_real; ++i) {
    if (!near[i]) {
      close_row(i, false);
      continue;
    }
    around.clear();
    particles.append_within(positions[i], range, static_cast<Index>(n_free), around);
    for (const Index j : around)
      if (near[j] && j > i) pairs.index.push_back(j);
    close_row(i, true);
    for (const Index j : around)
      if (!near[j]) pairs.index.push_back(j);
    pairs.offset.back() = static_cast<Index>(pairs.index.size());
  }
}

template void pair_up<2>(std::span<const Vec<2>>, std::size_t, std::size_t, double, Pairs&);
template void pair_up<3>(std::span<const Vec<3>>, std::size_t, std::size_t, double, Pairs&);

}  // namespace poretwin::solid
