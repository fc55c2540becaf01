// Consistent mapping: a plane through the neighbours by weighted least squares, for four receiving points at a time.
#include "common/core/threads.hpp"
#include "coupler/mapping.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace poretwin::coupling {
namespace {

using Size = std::size_t;

/// Columns (components of fields) are summed four at a time, so that the sums stay in registers.
constexpr Size columns_at_once = 4;

/// Index of entry (a, b), a <= b, in the stored upper triangle of a symmetric matrix.
template <int D>
constexpr Size upper(Size a, Size b) {
  return a * D - a * (a + 1) / 2 + b;
}
template <int D>
inline constexpr Size n_upper = D*(D + 1) / 2;

/// Sums over the neighbours of a point: of w, w h, w r and w r r^T, with their weights w, their smoothing lengths h and
/// their positions r relative to the point.
template <int D>
struct Moments {
  Quad w{}, wh{};
  std::array<Quad, D> wr{};
  std::array<Quad, n_upper<D>> wrr{};
};

/// Interpolation plane of a point: a neighbour at the relative position r has the coefficient w (constant - slope . r).
template <int D>
struct Plane {
  Lanes constant;  ///< includes the division by the sum of weights; 0 without neighbours
  std::array<Quad, D> slope;
};

/// Fraction of the slope that is used: 0 if the smallest eigenvalue of the neighbours' covariance, over the square of
/// their mean smoothing length, is below slope_off; 1 if above slope_full; linear in between.
[[gnu::always_inline]] inline void slope_share(const std::array<Quad, n_upper<2>>& c, const Lanes& square,
                                               Lanes& share) {
  const Lanes half = 0.5 * (c[0].v - c[2].v);
  Lanes root = half * half + c[1].v * c[1].v;
  sqrt_in_place(root);
  share = ((0.5 * (c[0].v + c[2].v) - root) / square - slope_off) / (slope_full - slope_off);
  max_in_place(share, Lanes{});
  min_in_place(share, Lanes{} + 1.0);
}
[[gnu::always_inline]] inline void slope_share(const std::array<Quad, n_upper<3>>& c, const Lanes& square,
                                               Lanes& share) {
  // All eigenvalues exceed a bound if and only if all leading minors of (matrix - bound I) are positive.
  const Lanes bound = slope_full * square;
  const Lanes a = c[0].v - bound, b = c[3].v - bound, d = c[5].v - bound;
  const Lanes minor = a * b - c[1].v * c[1].v;
  const Lanes determinant =
      a * (b * d - c[4].v * c[4].v) - c[1].v * (c[1].v * d - c[4].v * c[2].v) + c[2].v * (c[1].v * c[4].v - b * c[2].v);
  const LaneMask full = (a > 0.0) & (minor > 0.0) & (determinant > 0.0);
  share = Lanes{} + 1.0;
  if (!any(~full)) return;
  for (Size l = 0; l < n_lanes; ++l) {
    if (full[l]) continue;
    Mat<3> covariance;
    covariance << c[0].v[l], c[1].v[l], c[2].v[l], c[1].v[l], c[3].v[l], c[4].v[l], c[2].v[l], c[4].v[l], c[5].v[l];
    Eigen::SelfAdjointEigenSolver<Mat<3>> solver;
    solver.computeDirect(covariance, Eigen::EigenvaluesOnly);
    share[l] = std::clamp((solver.eigenvalues()[0] / square[l] - slope_off) / (slope_full - slope_off), 0.0, 1.0);
  }
}

/// Solves C x = b for a symmetric matrix; x = 0 in lanes where `regular` is not set.
[[gnu::always_inline]] inline void solve(const std::array<Quad, n_upper<2>>& c, const std::array<Quad, 2>& b,
                                         const LaneMask& regular, std::array<Quad, 2>& x) {
  const Lanes determinant = c[0].v * c[2].v - c[1].v * c[1].v;
  const Lanes inverse = regular ? 1.0 / (regular ? determinant : Lanes{} + 1.0) : Lanes{};
  x[0].v = inverse * (c[2].v * b[0].v - c[1].v * b[1].v);
  x[1].v = inverse * (c[0].v * b[1].v - c[1].v * b[0].v);
}
[[gnu::always_inline]] inline void solve(const std::array<Quad, n_upper<3>>& c, const std::array<Quad, 3>& b,
                                         const LaneMask& regular, std::array<Quad, 3>& x) {
  const Lanes m00 = c[3].v * c[5].v - c[4].v * c[4].v, m01 = c[2].v * c[4].v - c[1].v * c[5].v,
              m02 = c[1].v * c[4].v - c[2].v * c[3].v, m11 = c[0].v * c[5].v - c[2].v * c[2].v,
              m12 = c[1].v * c[2].v - c[0].v * c[4].v, m22 = c[0].v * c[3].v - c[1].v * c[1].v;
  const Lanes determinant = c[0].v * m00 + c[1].v * m01 + c[2].v * m02;
  const Lanes inverse = regular ? 1.0 / (regular ? determinant : Lanes{} + 1.0) : Lanes{};
  x[0].v = inverse * (m00 * b[0].v + m01 * b[1].v + m02 * b[2].v);
  x[1].v = inverse * (m01 * b[0].v + m11 * b[1].v + m12 * b[2].v);
  x[2].v = inverse * (m02 * b[0].v + m12 * b[1].v + m22 * b[2].v);
}

template <int D>
[[gnu::always_inline]] inline void fit(const Moments<D>& m, Plane<D>& plane) {
  const LaneMask covered = m.w.v > no_weight;
  const Lanes scale = covered ? 1.0 / (covered ? m.w.v : Lanes{} + 1.0) : Lanes{};
  std::array<Quad, D> mean;
  std::array<Quad, n_upper<D>> covariance;
  for (Size a = 0; a < D; ++a) mean[a].v = scale * m.wr[a].v;
  for (Size a = 0; a < D; ++a)
    for (Size b = a; b < D; ++b) covariance[upper<D>(a, b)].v = scale * m.wrr[upper<D>(a, b)].v - mean[a].v * mean[b].v;
  const Lanes length = covered ? scale * m.wh.v : Lanes{} + 1.0;
  Lanes share;
  slope_share(covariance, length * length, share);
  solve(covariance, mean, share > 0.0, plane.slope);
  Lanes constant = Lanes{} + 1.0;
  for (Size a = 0; a < D; ++a) {
    plane.slope[a].v *= share;
    constant += plane.slope[a].v * mean[a].v;
    plane.slope[a].v *= scale;
  }
  plane.constant = scale * constant;
}

/// Fields of one group, stored point by point so that a cache line holds several values of one point. Fields that are
/// zero everywhere are left out.
struct Columns {
  std::vector<const Field*> given;
  std::vector<Field*> mapped;
  std::vector<Size> may_jump;  ///< columns of properties that jump somewhere
  Size n = 0, width = 0;       ///< number of columns; rounded up to whole registers
  std::vector<double> values;  ///< [points * width]
};

void pack(Size n_points, Columns& out) {
  for (const Field* field : out.given) out.n += static_cast<Size>(field->components);
  out.width = (out.n + columns_at_once - 1) / columns_at_once * columns_at_once;
  out.values.resize(n_points * out.width);
  parallel_ranges(n_points, worth_threads_in_points, [&](Size begin, Size end) {
    Size column = 0;
    for (const Field* field : out.given) {
      const Size components = static_cast<Size>(field->components);
      for (Size j = begin; j < end; ++j)
        for (Size c = 0; c < components; ++c)
          out.values[j * out.width + column + c] = field->values[j * components + c];
      column += components;
    }
  });
}

/// Adds a neighbour to the sums.
template <int D>
[[gnu::always_inline]] inline void add(Moments<D>& m, const Lanes& w, const typename PairBlocks<D>::Node& node,
                                       const std::array<Quad, D>& x) {
  m.w.v += w;
  m.wh.v += w * node.length;
  for (Size a = 0; a < D; ++a) {
    const Lanes wr = w * (node.x[a] - x[a].v);
    m.wr[a].v += wr;
    for (Size b = a; b < D; ++b) m.wrr[upper<D>(a, b)].v += wr * (node.x[b] - x[b].v);
  }
}

/// In the lanes `limited`, limits interpolated values of four columns to the range of the neighbours' values.
[[gnu::always_inline]] inline void cut_at_range(std::span<const Index> near, const Quad* weight, const double* values,
                                                Size width, const LaneMask& limited, Quad* total) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  std::array<Quad, columns_at_once> low, high;
  for (Size q = 0; q < columns_at_once; ++q) {
    low[q].v = Lanes{} + infinite;
    high[q].v = Lanes{} - infinite;
  }
  for (Size c = 0; c < near.size(); ++c) {
    const LaneMask counts = weight[c].v > 0.0;
    const double* const value = values + near[c] * width;
    for (Size q = 0; q < columns_at_once; ++q) {
      min_in_place(low[q].v, counts ? Lanes{} + value[q] : Lanes{} + infinite);
      max_in_place(high[q].v, counts ? Lanes{} + value[q] : Lanes{} - infinite);
    }
  }
  for (Size q = 0; q < columns_at_once; ++q) {
    Lanes kept = total[q].v;
    max_in_place(kept, low[q].v);
    min_in_place(kept, high[q].v);
    total[q].v = limited ? kept : total[q].v;
  }
}

/// The values of all columns at the points of a block.
template <int D>
[[gnu::always_inline]] inline void interpolate(const typename PairBlocks<D>::Node* nodes, const std::array<Quad, D>& x,
                                               std::span<const Index> near, const Quad* weight,
                                               const Moments<D>& moments, const Columns& columns, Quad* coefficient,
                                               Quad* total) {
  Plane<D> plane;
  fit(moments, plane);
  Lanes least{};
  for (Size column = 0; column < columns.width; column += columns_at_once) {
    const double* const values = columns.values.data() + column;
    std::array<Quad, columns_at_once> sum{};
    for (Size c = 0; c < near.size(); ++c) {
      Lanes k;
      if (column == 0) {
        const auto& node = nodes[near[c]];
        k = plane.constant;
        for (Size a = 0; a < D; ++a) k -= plane.slope[a].v * (node.x[a] - x[a].v);
        k *= weight[c].v;
        min_in_place(least, k);
        coefficient[c].v = k;
      } else {
        k = coefficient[c].v;
      }
      const double* const value = values + near[c] * columns.width;
      for (Size q = 0; q < columns_at_once; ++q) sum[q].v += k * value[q];
    }
    for (Size q = 0; q < columns_at_once; ++q) total[column + q] = sum[q];
  }
  // Where coefficients are negative, the value may leave the range of the neighbours' values, and is limited to it.
  const LaneMask leaves = least < 0.0;
  if (!any(leaves)) return;
  for (Size column = 0; column < columns.width; column += columns_at_once)
    cut_at_range(near, weight, columns.values.data() + column, columns.width, leaves, total + column);
}

/// Whether any values of this property differ by more than the factor `jump`.
bool jumps_anywhere(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return low != values.end() && *high > jump * *low;
}

/// Where the values of a column jump among the neighbours of a point, replaces the interpolated value by the value of
/// the neighbour with the largest weight.
[[gnu::always_inline]] inline void take_nearest(std::span<const Index> near, const Quad* weight, const Columns& columns,
                                                Quad* total) {
  Lanes most{};
  std::array<Index, n_lanes> nearest{};
  for (Size c = 0; c < near.size(); ++c) {
    const LaneMask nearer = weight[c].v > most;
    if (!any(nearer)) continue;
    for (Size l = 0; l < n_lanes; ++l)
      if (nearer[l]) nearest[l] = near[c];
    max_in_place(most, weight[c].v);
  }
  for (const Size column : columns.may_jump) {
    Lanes low = Lanes{} + std::numeric_limits<double>::infinity(), high{};
    for (Size c = 0; c < near.size(); ++c) {
      const LaneMask counts = weight[c].v > 0.0;
      const Lanes value = Lanes{} + columns.values[near[c] * columns.width + column];
      min_in_place(low, counts ? value : low);
      max_in_place(high, counts ? value : high);
    }
    for (Size l = 0; l < n_lanes; ++l)
      if (high[l] > jump * low[l]) total[column].v[l] = columns.values[nearest[l] * columns.width + column];
  }
}

/// Writes the columns at the points of a block to the fields to which they belong.
template <int D>
void hand_out(const typename PairBlocks<D>::Block& block, const Quad* total, std::span<Field* const> fields) {
  for (auto* const field : fields) {
    const Size components = static_cast<Size>(field->components);
    for (Size l = 0; l < block.used; ++l)
      for (Size c = 0; c < components; ++c) field->values[block.point[l] * components + c] = total[c].v[l];
    total += components;
  }
}

/// Computes coverage, asymmetry and spread at the points of a block.
template <int D>
[[gnu::always_inline]] inline void find_surroundings(const typename PairBlocks<D>::Block& block, const Moments<D>& m,
                                                     Interpolation& out) {
  Lanes first{}, second{};
  for (Size a = 0; a < D; ++a) {
    first += m.wr[a].v * m.wr[a].v;
    second += m.wrr[upper<D>(a, a)].v;
  }
  const LaneMask covered = m.w.v > no_weight;
  const Lanes length = covered ? m.wh.v : Lanes{} + 1.0;
  Lanes asymmetry = first, spread = m.w.v * second - first;
  max_in_place(spread, Lanes{});
  sqrt_in_place(asymmetry);
  sqrt_in_place(spread);
  asymmetry = covered ? asymmetry / length : Lanes{};
  spread = covered ? spread / length : Lanes{};
  for (Size l = 0; l < block.used; ++l) {
    out.coverage[block.point[l]] = covered[l] ? m.w.v[l] : 0.0;
    out.asymmetry[block.point[l]] = asymmetry[l];
    out.spread[block.point[l]] = spread[l];
  }
}

}  // namespace

bool all_zero(const std::vector<double>& values) {
  constexpr Size at_once = 64;
  for (Size k = 0; k < values.size(); k += at_once) {
    bool zero = true;
    for (Size i = k; i < std::min(k + at_once, values.size()); ++i) zero &= values[i] == 0.0;
    if (!zero) return false;
  }
  return true;
}

template <int D>
Interpolation consistent(const PairBlocks<D>& pairs, std::span<const FieldGroup> groups, const PairWeights* made) {
  const Size m = pairs.n_active();
  const std::vector<double> zero(m, 0.0);
  Interpolation out{zero, zero, zero, {}};
  for (const auto& group : groups)
    for (const auto* fields : {&group.fields, &group.properties})
      for (const Field* field : *fields)
        out.fields.push_back(
            {field->name, field->components, std::vector<double>(m * static_cast<Size>(field->components), 0.0)});
  std::vector<Columns> packed(groups.size());
  Size widest = 0, next = 0;
  for (Size g = 0; g < groups.size(); ++g) {
    Size column = 0;
    for (const auto* fields : {&groups[g].fields, &groups[g].properties})
      for (const Field* field : *fields) {
        Field& mapped = out.fields[next++];
        if (all_zero(field->values)) continue;
        packed[g].given.push_back(field);
        packed[g].mapped.push_back(&mapped);
        const bool jumps = fields == &groups[g].properties && jumps_anywhere(field->values);
        for (int c = 0; c < field->components; ++c, ++column)
          if (jumps) packed[g].may_jump.push_back(column);
      }
    pack(pairs.nodes().size(), packed[g]);
    widest = std::max(widest, packed[g].width);
  }
  const auto* const nodes = pairs.nodes().data();
  const auto blocks = pairs.active_blocks();
  parallel_ranges(blocks.size(), worth_threads_in_blocks, [&](Size begin, Size end) {
    std::vector<Index> found(pairs.longest_list());
    std::vector<Quad> weighed(found.size()), masked(weighed), coefficient(weighed), total(widest);
    run_lanes([&]() __attribute__((always_inline)) {
      for (Size b = begin; b < end; ++b) {
        const auto& block = blocks[b];
        const std::array<Quad, D> x = block.x;
        std::span<const Index> near;
        const Quad* weight;
        if (made) {
          near = std::span(made->candidate).subspan(block.first, made->last[b] - block.first);
          weight = made->weight.data() + block.first;
        } else {
          near = std::span(found).first(
              weigh_block<Kernel::of_candidate, D>(pairs, block, {}, found.data(), weighed.data()));
          weight = weighed.data();
        }
        if (near.empty()) continue;  // all values remain 0 there
        Moments<D> whole;
        for (Size c = 0; c < near.size(); ++c) add<D>(whole, weight[c].v, nodes[near[c]], x);
        find_surroundings<D>(block, whole, out);
        for (Size g = 0; g < groups.size(); ++g) {
          const auto& columns = packed[g];
          if (columns.n == 0) continue;
          const Quad* counts = weight;
          if (groups[g].mask.empty()) {
            interpolate<D>(nodes, x, near, weight, whole, columns, coefficient.data(), total.data());
          } else {  // the mask changes weights and moments
            Moments<D> part;
            for (Size c = 0; c < near.size(); ++c) {
              const Lanes w = weight[c].v * groups[g].mask[near[c]];
              masked[c].v = w;
              add<D>(part, w, nodes[near[c]], x);
            }
            counts = masked.data();
            interpolate<D>(nodes, x, near, counts, part, columns, coefficient.data(), total.data());
          }
          if (!columns.may_jump.empty()) take_nearest(near, counts, columns, total.data());
          hand_out<D>(block, total.data(), columns.mapped);
        }
      }
    });
  });
  return out;
}

template Interpolation consistent<2>(const PairBlocks<2>&, std::span<const FieldGroup>, const PairWeights*);
template Interpolation consistent<3>(const PairBlocks<3>&, std::span<const FieldGroup>, const PairWeights*);

}  // namespace poretwin::coupling
