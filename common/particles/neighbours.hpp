// Neighbour search: a grid of cells over sorted points, and lists of pairs that stay valid for small displacements
// (skin).
#pragma once

#include "common/core/lanes.hpp"
#include "common/core/threads.hpp"
#include "common/core/vector.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace poretwin::sph {

/// Points sorted into square cells. Memory is bounded by the number of points, not by the extent of the domain.
template <int D>
class CellGrid {
 public:
  /// cell_size [m]: about the search radius, or half of it. Points may lie anywhere. Throws DivergedError if a
  /// coordinate is not finite.
  void build(std::span<const Vec<D>> points, double cell_size);

  /// Calls f(j, squared distance) for every point j with |x - x_j| < radius; fastest for radius <= 2 cell_size.
  template <class F>
  void for_each_within(const Vec<D>& x, double radius, F&& f) const {
    const double limit = radius * radius;
    // Few points of a row are near: hence all distances are computed first, without branches.
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

  /// Calls f(begin, end) for ranges of order(). Together the ranges contain all points in the box, and some around it.
  template <class F>
  void for_each_piece_near(const Vec<D>& lower, const Vec<D>& upper, F&& f) const {
    for_each_row(lower, upper, f);
  }

  /// Appends every point j with |x - x_j| < radius for which admit(j, squared distance) is true. Distances are computed
  /// in lanes and without branches, which would often be mispredicted. Inlined into the jobs of run_lanes().
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
  /// Calls f(begin, end) with the range in order_ of each row of cells in the box. The cells of a row are contiguous.
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

  std::array<ScalarArray, D> axis_;  ///< coordinates in cell order, padded for reads by lanes
  Vec<D> lower_ = Vec<D>::Zero();
  double size_ = 1.0;
  std::array<int, D> count_{};
  std::vector<Index> first_, order_;  ///< order_ is padded for reads by lanes
  std::vector<Index> cell_of_;
};

/// Neighbours of every target among the sources, in compressed rows: of target a, index[offset[a] .. offset[a+1]).
struct PairList {
  std::vector<Index> offset{0};
  std::vector<Index> index;
  [[nodiscard]] std::size_t size() const { return offset.size() - 1; }
  [[nodiscard]] std::span<const Index> of(std::size_t a) const {
    return std::span(index).subspan(offset[a], offset[a + 1] - offset[a]);
  }
};

/// All pairs (a, j) with |x_a - y_j| < radius_j (the source's radius), with sources in ascending order. exclude_self
/// leaves out the pairs (a, a); the targets must then be the first of the sources.
template <int D>
PairList find_pairs(std::span<const Vec<D>> targets, std::span<const Vec<D>> sources, std::span<const double> radius,
                    bool exclude_self = false);

}  // namespace poretwin::sph
