// Neighbour search: a cell grid over sorted points, and pair lists that outlive small displacements (a skin).
#pragma once

#include "common/core/error.hpp"
#include "common/core/lanes.hpp"
#include "common/core/threads.hpp"
#include "common/core/vector.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace poretwin::sph {

/// Points binned into square cells; memory is bounded by the number of points, not by the extent of the domain.
template <int D>
class CellGrid {
 public:
  /// cell_size [m]: about the search radius, or half of it. Points need not be inside any box. Throws DivergedError
  /// where a point is not finite.
  void build(std::span<const Vec<D>> points, double cell_size) {
    lower_ = Vec<D>::Zero();
    std::array<double, D> extent{};
    const std::size_t n = points.size(), parts = parts_for(n);
    if (!points.empty()) {
      VecArray<D> lowers(parts, points[0]), uppers(parts, points[0]);
      ScalarArray doubt(parts, 0.0);
      for_each_part(parts, [&](std::size_t part) {
        Vec<D> least = points[0], most = points[0];  // of its own: what parts share a line of is slow to write
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
      if (std::ranges::any_of(doubt, [](double sum) { return sum != 0.0; })) refuse(points);
      Vec<D> upper = uppers[0];
      lower_ = lowers[0];
      for (std::size_t part = 1; part < parts; ++part) {
        lower_ = lower_.cwiseMin(lowers[part]);
        upper = upper.cwiseMax(uppers[part]);
      }
      for (int d = 0; d < D; ++d) extent[static_cast<std::size_t>(d)] = upper[d] - lower_[d];
    }
    // A stray far particle must not blow up the grid: grow the cells until there are at most 4 per point.
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
    // Counted by parts, so that all of them sort at once, and points of a cell stay in order.
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
    order_.assign(n == 0 ? 0 : n + n_lanes, 0);  // what is read by lanes may begin at the last point
    for_each_part(parts, [&](std::size_t part) {
      for (std::size_t i = n * part / parts; i < n * (part + 1) / parts; ++i)
        order_[next[part][cell_of_[i]]++] = static_cast<Index>(i);
    });
    cell_of_ = std::vector<Index>();  // "= {}" would keep its memory
    for (std::size_t d = 0; d < D; ++d) {
      axis_[d].resize(n + n_lanes);
      parallel_for(n, [&](std::size_t m) { axis_[d][m] = points[order_[m]][static_cast<int>(d)]; });
    }
  }

  /// Calls f(j, squared distance) for every point j with |x - x_j| < radius; fastest for radius <= 2 cell_size.
  template <class F>
  void for_each_within(const Vec<D>& x, double radius, F&& f) const {
    const double limit = radius * radius;
    // Few points of a row are near: the distances first, without branches.
    constexpr Index batch = 64;
    std::array<Index, batch> near;
    std::array<double, batch> distance;
    for_each_row((x.array() - radius).matrix(), (x.array() + radius).matrix(), [&](Index begin, Index end) {
      for (Index from = begin; from < end; from += batch) {
        const Index to = std::min(end, from + batch);
        std::size_t n = 0;
        for (Index m = from; m < to; ++m) {
          double r2 = 0.0;
          for (std::size_t d = 0; d < D; ++d) {
            const double apart = axis_[d][m] - x[static_cast<int>(d)];
            r2 += apart * apart;
          }
          near[n] = m;
          distance[n] = r2;
          n += r2 < limit ? 1 : 0;
        }
        for (std::size_t i = 0; i < n; ++i) f(order_[near[i]], distance[i]);
      }
    });
  }

  /// Calls f(begin, end) for pieces of order() that hold all points in the box, and some around it.
  template <class F>
  void for_each_piece_near(const Vec<D>& lower, const Vec<D>& upper, F&& f) const {
    for_each_row(lower, upper, f);
  }

  /// Appends every point j with |x - x_j| < radius that admit(j, squared distance) takes. Distances by lanes, and no
  /// branch that depends on them: it would be guessed wrong too often. Inline in what run_lanes() runs.
  template <class Admit>
  [[gnu::always_inline]] inline void append_within(const Vec<D>& x, double radius, std::vector<Index>& found,
                                                   const Admit& admit) const {
    const double limit = radius * radius;
    constexpr std::size_t room = 256, batch = 64;
    std::array<Index, room + n_lanes> near;
    std::size_t n = 0;
    const auto search = [&](Index begin, Index end) __attribute__((always_inline)) {
      for (std::size_t from = begin; from < end; from += batch) {
        const std::size_t to = std::min<std::size_t>(end, from + batch);
        if (n + (to - from) > room) {
          found.insert(found.end(), near.begin(), near.begin() + static_cast<std::ptrdiff_t>(n));
          n = 0;
        }
        for (std::size_t m = from; m < to; m += n_lanes) {
          Lanes r2{};
          for (std::size_t d = 0; d < D; ++d) {
            const Lanes apart = *reinterpret_cast<const LooseLanes*>(&axis_[d][m]) - x[static_cast<int>(d)];
            r2 += apart * apart;
          }
          for (std::size_t l = 0; l < n_lanes; ++l) {
            const Index j = order_[m + l];
            near[n] = j;
            n += static_cast<std::size_t>(m + l < to) & static_cast<std::size_t>(r2[l] < limit) &
                 static_cast<std::size_t>(admit(j, r2[l]));
          }
        }
      }
    };
    for_each_row((x.array() - radius).matrix(), (x.array() + radius).matrix(), search);
    found.insert(found.end(), near.begin(), near.begin() + static_cast<std::ptrdiff_t>(n));
  }

  /// Point indices in cell order: a permutation under which neighbours lie close in memory.
  [[nodiscard]] std::span<const Index> order() const {
    return std::span(order_).first(order_.empty() ? 0 : order_.size() - n_lanes);
  }

 private:
  [[noreturn]] static void refuse(std::span<const Vec<D>> points) {
    const auto lost = std::ranges::find_if(points, [](const Vec<D>& x) { return !x.allFinite(); });
    throw DivergedError(fmt::format("particle or image {} of {} is at ({}): the motion diverged", lost - points.begin(),
                                    points.size(), fmt::join(lost->data(), lost->data() + D, ", ")));
  }

  /// Calls f(begin, end) of order_ for every row of cells in the box: the cells of a row lie one after the other.
  template <class F>
  [[gnu::always_inline]] inline void for_each_row(const Vec<D>& lower, const Vec<D>& upper, F&& f) const {
    if (order_.empty()) return;
    std::array<int, D> lo{}, hi{};
    for (std::size_t d = 0; d < D; ++d) {
      const int k = static_cast<int>(d);
      lo[d] = static_cast<int>(std::floor(std::clamp((lower[k] - lower_[k]) / size_, -1.0, 1.0 * count_[d])));
      hi[d] = static_cast<int>(std::floor(std::clamp((upper[k] - lower_[k]) / size_, -1.0, 1.0 * count_[d])));
      lo[d] = std::max(lo[d], 0);
      hi[d] = std::min(hi[d], count_[d] - 1);
      if (lo[d] > hi[d]) return;
    }
    const auto row = [&](std::array<int, D> c) __attribute__((always_inline)) {
      c[0] = lo[0];
      const Index begin = first_[flat(c)];
      c[0] = hi[0];
      f(begin, first_[flat(c) + 1]);
    };
    std::array<int, D> c{};
    if constexpr (D == 2) {
      for (c[1] = lo[1]; c[1] <= hi[1]; ++c[1]) row(c);
    } else {
      for (c[2] = lo[2]; c[2] <= hi[2]; ++c[2])
        for (c[1] = lo[1]; c[1] <= hi[1]; ++c[1]) row(c);
    }
  }

  std::array<int, D> cell(const Vec<D>& x) const {
    std::array<int, D> c{};
    for (std::size_t d = 0; d < D; ++d)
      c[d] = std::clamp(static_cast<int>(std::floor((x[static_cast<int>(d)] - lower_[static_cast<int>(d)]) / size_)), 0,
                        count_[d] - 1);
    return c;
  }
  [[gnu::always_inline]] inline std::size_t flat(const std::array<int, D>& c) const {
    std::size_t k = static_cast<std::size_t>(c[D - 1]);
    for (std::size_t d = D - 1; d-- > 0;) k = k * static_cast<std::size_t>(count_[d]) + static_cast<std::size_t>(c[d]);
    return k;
  }

  std::array<ScalarArray, D> axis_;  ///< coordinates in cell order, and room for lanes behind them
  Vec<D> lower_ = Vec<D>::Zero();
  double size_ = 1.0;
  std::array<int, D> count_{};
  std::vector<Index> first_, order_;  ///< order_: with room for lanes behind it
  std::vector<Index> cell_of_;
};

/// Neighbours of every target among the sources, compressed rows: of target a, index[offset[a] .. offset[a+1]).
struct PairList {
  std::vector<Index> offset{0};
  std::vector<Index> index;
  [[nodiscard]] std::size_t size() const { return offset.size() - 1; }
  [[nodiscard]] std::span<const Index> of(std::size_t a) const {
    return std::span(index).subspan(offset[a], offset[a + 1] - offset[a]);
  }
};

/// All pairs (a, j) with |x_a - y_j| < radius_j (scatter: the source's radius counts), sources in ascending order.
/// With exclude_self, pair (a, a) is left out (targets being the first of the sources).
template <int D>
PairList find_pairs(std::span<const Vec<D>> targets, std::span<const Vec<D>> sources, std::span<const double> radius,
                    bool exclude_self = false) {
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

}  // namespace poretwin::sph
