#include "common/particles/neighbours.hpp"

#include "common/core/error.hpp"
#include "common/core/threads.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace poretwin::sph {
namespace {

template <int D>
[[noreturn]] void refuse(std::span<const Vec<D>> points) {
  const auto lost = std::ranges::find_if(points, [](const Vec<D>& x) { return !x.allFinite(); });
  throw DivergedError(fmt::format("particle or image {} of {} is at ({}): the motion diverged", lost - points.begin(),
                                  points.size(), fmt::join(lost->data(), lost->data() + D, ", ")));
}

}  // namespace

template <int D>
void CellGrid<D>::build(std::span<const Vec<D>> points, double cell_size) {
  lower_ = Vec<D>::Zero();
  std::array<double, D> extent{};
  const std::size_t n = points.size(), parts = parts_for(n);
  if (!points.empty()) {
    VecArray<D> lowers(parts, points[0]), uppers(parts, points[0]);
    ScalarArray doubt(parts, 0.0);
    for_each_part(parts, [&](std::size_t part) {
      Vec<D> least = points[0], most = points[0];  // local, since writing to memory that threads share is slow
      double sum = 0.0;
      for (std::size_t i = n * part / parts; i < n * (part + 1) / parts; ++i) {
        least = least.cwiseMin(points[i]);
        most = most.cwiseMax(points[i]);
        sum += 0.0 * points[i].sum();
      }
      lowers[part] = least;
      uppers[part] = most;
      doubt[part] = sum;
    });
    if (std::ranges::any_of(doubt, [](double sum) { return sum != 0.0; })) refuse<D>(points);
    Vec<D> upper = uppers[0];
    lower_ = lowers[0];
    for (std::size_t part = 1; part < parts; ++part) {
      lower_ = lower_.cwiseMin(lowers[part]);
      upper = upper.cwiseMax(uppers[part]);
    }
    for (int d = 0; d < D; ++d) extent[static_cast<std::size_t>(d)] = upper[d] - lower_[d];
  }
  // One point far away must not enlarge the grid without limit: cells are enlarged until there are at most 4 per point.
  size_ = cell_size;
  const double limit = 4.0 * static_cast<double>(points.size()) + 64.0;
  for (;;) {
    double cells = 1.0;
    for (std::size_t d = 0; d < D; ++d) cells *= std::floor(extent[d] / size_) + 1.0;
    if (cells <= limit) break;
    size_ *= 1.5;
  }
  std::size_t n_cells = 1;
  for (std::size_t d = 0; d < D; ++d) {
    count_[d] = static_cast<int>(std::floor(extent[d] / size_)) + 1;
    n_cells *= static_cast<std::size_t>(count_[d]);
  }
  // Points are counted by parts: then all parts can sort at the same time, and points of a cell keep their order.
  cell_of_.resize(n);
  std::vector<std::vector<Index>> next(parts);
  for_each_part(parts, [&](std::size_t part) {
    next[part].assign(n_cells, 0);
    for (std::size_t i = n * part / parts; i < n * (part + 1) / parts; ++i) {
      cell_of_[i] = static_cast<Index>(flat(cell(points[i])));
      ++next[part][cell_of_[i]];
    }
  });
  first_.resize(n_cells + 1);
  first_[0] = 0;
  for (std::size_t c = 0; c < n_cells; ++c) {
    Index place = first_[c];
    for (auto& counts : next) {
      const Index count = counts[c];
      counts[c] = place;
      place += count;
    }
    first_[c + 1] = place;
  }
  order_.assign(n == 0 ? 0 : n + n_lanes, 0);  // reads by lanes may begin at the last point
  for_each_part(parts, [&](std::size_t part) {
    for (std::size_t i = n * part / parts; i < n * (part + 1) / parts; ++i)
      order_[next[part][cell_of_[i]]++] = static_cast<Index>(i);
  });
  cell_of_ = std::vector<Index>();  // assigning {} would not free its memory
  for (std::size_t d = 0; d < D; ++d) {
    axis_[d].resize(n + n_lanes);
    parallel_for(n, [&](std::size_t m) { axis_[d][m] = points[order_[m]][static_cast<int>(d)]; });
  }
}

template <int D>
PairList find_pairs(std::span<const Vec<D>> targets, std::span<const Vec<D>> sources, std::span<const double> radius,
                    bool exclude_self) {
  PairList list;
  list.offset.assign(1, 0);
  list.offset.reserve(targets.size() + 1);
  const double largest = radius.empty() ? 1.0 : *std::max_element(radius.begin(), radius.end());
  CellGrid<D> grid;
  grid.build(sources, largest);
  for (std::size_t a = 0; a < targets.size(); ++a) {
    const std::size_t begin = list.index.size();
    grid.for_each_within(targets[a], largest, [&](Index j, double r2) {
      if (r2 < radius[j] * radius[j] && !(exclude_self && j == a)) list.index.push_back(j);
    });
    std::sort(list.index.begin() + static_cast<std::ptrdiff_t>(begin), list.index.end());
    list.offset.push_back(static_cast<Index>(list.index.size()));
  }
  return list;
}

template void CellGrid<2>::build(std::span<const Vec<2>>, double);
template void CellGrid<3>::build(std::span<const Vec<3>>, double);
template PairList find_pairs<2>(std::span<const Vec<2>>, std::span<const Vec<2>>, std::span<const double>, bool);
template PairList find_pairs<3>(std::span<const Vec<3>>, std::span<const Vec<3>>, std::span<const double>, bool);

}  // namespace poretwin::sph
