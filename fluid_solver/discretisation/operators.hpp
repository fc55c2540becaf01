// Differential operators on a stencil: corrected gradient and divergence, pairwise Laplacian, interpolation.
#pragma once

#include "common/core/lanes.hpp"
#include "common/numerics/csr.hpp"
#include "common/particles/for_pairs.hpp"
#include "fluid_solver/discretisation/stencil.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace poretwin::fluid {

/// Whether the images of a vector field behind a moving wall include the wall's velocity. For velocities of the water
/// they do.
enum class Carried : bool { no, yes };

/// The value of a field at point j, from the values at the particles. An image takes its parent's value. A vector
/// is mapped by the image's linear map, or changes its sign behind walls at which the field does not slip (`sticky`,
/// one bit for each wall). Buffers and their images get zero, which no caller uses.
template <int D>
[[gnu::always_inline]] inline Vec<D> extended_to(const Stencil<D>& s, std::span<const Vec<D>> f, std::size_t j,
                                                 Carried carried, std::uint32_t sticky) {
  const Index q = s.parent[j];
  if (q >= s.n_particles) return Vec<D>::Zero();
  if (j < s.n_base) return f[q];
  if (s.sticks(j, sticky)) return -f[q];
  Vec<D> image = s.map[j - s.n_base] * f[q];
  if (carried == Carried::yes) image += s.carried[j - s.n_base];
  return image;
}

/// The values of a field at all points, from those at the real particles; all ranks call this.
template <int D>
VecArray<D> extended(const Stencil<D>& s, std::span<const Vec<D>> f, Carried carried = Carried::no,
                     std::uint32_t sticky = 0) {
  const auto particles = s.with_copies(f);
  VecArray<D> all(s.size());
  parallel_for(s.size(), [&](std::size_t j) { all[j] = extended_to<D>(s, particles, j, carried, sticky); });
  return all;
}

inline double harmonic(double a, double b) {
  if (a == b) return a;
  return a + b > 0.0 ? 2.0 * a * b / (a + b) : 0.0;
}

/// Slopes of a pressure along the face columns' normals [Pa/m], 0 where the ground inside is dry; all ranks call this.
/// face_pressure(column): as in pressure_gradient.
template <int D, class Face>
ScalarArray face_slopes(const Stencil<D>& s, std::span<const double> p, const Face& face_pressure,
                        bool increment = false) {
  ScalarArray slopes(s.fitted.size(), 0.0);
  if (slopes.empty()) return slopes;
  const bool alone = s.domain.alone();
  if (alone && !increment) slopes = s.fit_constant;
  for (Index c = 0; c < slopes.size(); ++c)
    for (Index k = s.fit_offset[c]; k < s.fit_offset[c + 1]; ++k)
      slopes[c] += s.fit_weight[k] * (p[s.fit_index[k]] - face_pressure(c));
  if (alone) return slopes;
  s.domain.sum(slopes);
  for (std::size_t c = 0; !increment && c < slopes.size(); ++c) slopes[c] += s.fit_constant[c];
  return slopes;
}

/// Data of a point that pair loops use, packed: its position and n_values numbers, padded to a multiple of `step`.
template <int D, std::size_t n_values, std::size_t step = n_lanes>
struct alignas(step * sizeof(double)) PackedPoint {
  static constexpr std::size_t size = (D + n_values + step - 1) / step * step;
  std::array<double, size> x;  ///< not initialised: the code that packs a point sets all values that are used
  [[nodiscard]] const double* row() const { return x.data(); }
};
template <int D, std::size_t n_values>
using PackedPoints = UnsetArray<PackedPoint<D, n_values>>;

/// For every real particle a, calls add(pair, factor, w, point, sum) for each of its pairs, then take(a, total) with
/// the n_sums sums. factor: the pair's gradient factor. w: the factor times the vector to the other point. point: the
/// numbers that are packed with the other point after its position.
template <int D, std::size_t n_values, std::size_t n_sums, class Add, class Take>
void for_gradients(const Stencil<D>& s, const PackedPoints<D, n_values>& points, const Add& add, const Take& take) {
  for_pairs<SumsOf<n_sums>::template Row>(
      s.rows(), PairInputs{points.data()},
      [&](const auto& pair, auto& own) __attribute__((always_inline)) {
        using Number = NumberOf<decltype(pair)>;
        Number point[D + n_values], w[D], factor;
        gather<0, D + n_values>(pair.rows(), point);
        poretwin::take(&s.gradient_factor[pair.m], factor);
        for (std::size_t d = 0; d < D; ++d) w[d] = factor * (point[d] - pair.self[d]);
        add(pair, factor, w, point + D, own.sum);
      },
      [&](std::size_t a, const auto& own) __attribute__((always_inline)) {
        alignas(32) double total[SumsOf<n_sums>::size] = {};
        own.add_to(total);
        take(a, total);
      });
}

/// A mobility with its values at the copies. An empty one, which is 1, stays empty.
template <int D>
WithCopies<double> mobility_with_copies(const Stencil<D>& s, std::span<const double> mobility) {
  if (s.domain.any(!mobility.empty())) return s.with_copies(mobility);
  return {Domain(), mobility};
}

/// Corrected gradient of a piezometric pressure; all ranks call this. face_pressure(column): the pressure at a face;
/// surface_pressure(a): that of the free surface next to particle a (both 0 for increments). mobility: of the real
/// particles; pairs get the harmonic mean, and an empty mobility is 1. unresolved_gradient: the value in directions
/// without neighbours. increment: p is a change of pressure.
template <int D, class Face, class SurfacePressure>
VecArray<D> pressure_gradient(const Stencil<D>& s, std::span<const double> p, Face&& face_pressure,
                              std::span<const double> mobility, const Vec<D>& unresolved_gradient,
                              SurfacePressure&& surface_pressure, bool increment = false) {
  // Pressures of the buffers. A reflection for each particle, as in the Laplacian, would magnify the error of a
  // particle that lies on the face itself.
  const ScalarArray slopes = face_slopes(s, p, face_pressure, increment);
  ScalarArray buffer(s.n_base - s.n_particles);
  std::vector<bool> fitted(buffer.size());
  bool all_fitted = true;
  for (std::size_t i = 0; i < buffer.size(); ++i) {
    const Index column = s.buffers[i].column;
    fitted[i] = s.has_slope(column);
    all_fitted = all_fitted && fitted[i];
    buffer[i] = face_pressure(column) - (fitted[i] ? slopes[column] : 0.0) * s.buffers[i].outside;
  }
  // A buffer takes the mobility of the particle whose row is summed; a zero stands for this.
  const auto pressure = s.with_copies(p);
  const auto mobilities = mobility_with_copies(s, mobility);
  PackedPoints<D, 2> points(s.size());
  parallel_for(s.size(), [&](std::size_t j) {
    const Index q = s.parent[j];
    const bool particle = q < s.n_particles;
    for (std::size_t d = 0; d < D; ++d) points[j].x[d] = s.position[j][static_cast<int>(d)];
    points[j].x[D] = particle ? pressure[q] : buffer[q - s.n_particles];
    points[j].x[D + 1] = !particle ? 0.0 : mobilities.empty() ? 1.0 : mobilities[q];
  });
  VecArray<D> result(s.n_real);
  for_gradients<D, 2, D>(
      s, points,
      [&](const auto& pair, const auto&, const auto* w, const auto* point, auto* sum) __attribute__((always_inline)) {
        using Number = NumberOf<decltype(pair)>;
        const double* const self = pair.self + D;
        Number difference = point[0] - self[0];
        if (!all_fitted)
          pair.apply(
              [&](Index j, double x) {
                const Index q = s.parent[j];
                return q >= s.n_particles && !fitted[q - s.n_particles] ? x * s.reflection(pair.i, q) : x;
              },
              difference);
        if (!mobility.empty()) {
          const Number theirs = point[1] > 0.0 ? point[1] : Number{} + self[1];
          difference *= 2.0 * self[1] * theirs / (self[1] + theirs);
        }
        for (std::size_t d = 0; d < D; ++d) sum[d] += w[d] * difference;
      },
      [&](std::size_t a, const double* total) __attribute__((always_inline)) {
        const double own = mobility.empty() ? 1.0 : mobility[a];
        Vec<D> sum = Eigen::Map<const Vec<D>>(total);
        if (s.ghost_distance[a] > 0.0) sum += 2.0 * own * (p[a] - surface_pressure(a)) * s.normal[a];
        result[a] = s.correction[a] * sum;
        if (s.boundary_correction_of[a] > 0)
          result[a] += own * (s.boundary_corrections[s.boundary_correction_of[a] - 1].unresolved * unresolved_gradient);
      });
  return result;
}

/// Scales the flux along interfaces between soils; all ranks call this. The harmonic mean of a pair's mobilities is
/// right across an interface. Along the interface it slows the water of the more permeable soil and accelerates that of
/// the other soil. The part of the flux along the interface should follow each particle's own mobility, and so is
/// scaled by this mobility over the pairs' mean. flux: from pressure_gradient with the same mobility. in_soil [n]:
/// above one half in soil; other particles do not change.
template <int D>
void free_along_interfaces(const Stencil<D>& s, std::span<const double> mobility, std::span<const double> in_soil,
                           std::span<Vec<D>> flux) {
  const auto mobilities = s.with_copies(mobility), covered = s.with_copies(in_soil);
  parallel_for(s.n_real, [&](std::size_t a) {
    if (in_soil[a] <= 0.5) return;
    Vec<D> change = Vec<D>::Zero();
    Mat<D> plain = Mat<D>::Zero(), weighted = Mat<D>::Zero();
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
      const Index j = s.other[k], q = s.parent[j];
      const double theirs = q < s.n_particles && covered[q] > 0.5 ? mobilities[q] : mobility[a];
      const Vec<D> ba = s.position[j] - s.position[a], w = static_cast<double>(s.gradient_factor[k]) * ba;
      change += (theirs - mobility[a]) * w;
      plain += w * ba.transpose();
      weighted += harmonic(mobility[a], theirs) * w * ba.transpose();
    }
    if (change.isZero(0.0)) return;
    const Vec<D> n = change.normalized(), across = n.dot(flux[a]) * n;
    const double own = mobility[a] * (plain.trace() - n.dot(plain * n)), mean = weighted.trace() - n.dot(weighted * n);
    // At a flat interface the ratio is 0.7 to 1.7. It is bounded because around an island of one soil in another no
    // direction lies along the interface.
    if (mean > 0.0) flux[a] = across + std::clamp(own / mean, 0.5, 2.0) * (flux[a] - across);
  });
}

/// Calls take(a, sum) with sum_b V_b (f_b - f_a) grad W^T for every real particle a, without buffers. All ranks call
/// this.
template <int D, class Take>
void sum_differences(const Stencil<D>& s, std::span<const Vec<D>> f, Carried carried, std::uint32_t sticky,
                     const Take& take) {
  const bool buffers = s.n_base > s.n_particles;
  const auto particles = s.with_copies(f);
  PackedPoints<D, D> points(s.size());
  parallel_for(s.size(), [&](std::size_t j) {
    Eigen::Map<Vec<D>>{points[j].x.data()} = s.position[j];
    Eigen::Map<Vec<D>>{points[j].x.data() + D} = extended_to<D>(s, particles, j, carried, sticky);
  });
  for_gradients<D, D, D * D>(
      s, points,
      [&](const auto& pair, const auto&, const auto* w, const auto* point, auto* sum) __attribute__((always_inline)) {
        using Number = NumberOf<decltype(pair)>;
        Number open = Number{} + 1.0;
        if (buffers) pair.apply([&](Index j, double) { return s.is_buffer(j) ? 0.0 : 1.0; }, open);
        for (std::size_t c = 0; c < D; ++c) {
          const Number difference = open * (point[c] - pair.self[D + c]);
          for (std::size_t d = 0; d < D; ++d) sum[c + D * d] += w[d] * difference;
        }
      },
      [&](std::size_t a, const double* total)
          __attribute__((always_inline)) { take(a, Mat<D>(Eigen::Map<const Mat<D>>(total))); });
}

/// Corrected gradient of the water's velocity, G_ij = d v_i / d x_j [1/s], without buffers. sticky: walls at which
/// water does not slip, one bit for each wall.
template <int D>
MatArray<D> velocity_gradient(const Stencil<D>& s, std::span<const Vec<D>> f, std::uint32_t sticky = 0) {
  MatArray<D> result(s.n_real);
  sum_differences<D>(
      s, f, Carried::yes, sticky, [&](std::size_t a, const Mat<D>& sum) __attribute__((always_inline)) {
        result[a].noalias() = sum * s.correction_open(a);
      });
  return result;
}

/// Corrected divergence of a velocity-like field, without buffers (one-sided at faces). All ranks call this.
template <int D>
ScalarArray divergence(const Stencil<D>& s, std::span<const Vec<D>> f, Carried carried = Carried::no) {
  ScalarArray result(s.n_real, 0.0);
  if (carried == Carried::no && s.domain.all_of(f.size(), [&](std::size_t a) { return f[a].isZero(0.0); }))
    return result;
  sum_differences<D>(
      s, f, carried, 0, [&](std::size_t a, const Mat<D>& sum) __attribute__((always_inline)) {
        result[a] = sum.cwiseProduct(s.correction_open(a).transpose()).sum();
      });
  return result;
}

/// Distributes amounts of the real particles [n], in place: each amount among its particle and the real particles
/// around it, in proportion to the kernel's value times a weight, counts [n]. An amount without any neighbour of
/// positive weight stays where it is. The sum is conserved. All ranks call this.
template <int D>
void share_out(const Stencil<D>& s, std::span<const double> counts, std::span<Vec<D>> amounts) {
  const auto weights = s.with_copies(counts);
  // Data of a point: weight, smoothing length.
  PackedPoints<D, 2> points(s.size());
  parallel_for(s.size(), [&](std::size_t j) {
    auto& x = points[j].x;
    Eigen::Map<Vec<D>>{x.data()} = s.position[j];
    x[D] = j < s.n_particles ? weights[j] : 0.0;
    x[D + 1] = s.length(j);
  });
  const auto own = [&](std::size_t a) { return counts[a] * Kernel<D>::value(0.0, s.length(a)); };
  UnsetArray<float> value(s.other.size());  // of the kernel; equal for both particles of a pair
  VecArray<D> parts(s.size(), Vec<D>::Zero());
  for_pairs<SumsOf<1>::Row>(
      s.rows(), PairInputs{points.data()},
      [&](const auto& pair, auto& row) __attribute__((always_inline)) {
        using Number = NumberOf<decltype(pair)>;
        const double* const self = pair.self;
        Number point[D + 2], r{}, w;
        gather<0, D + 2>(pair.rows(), point);
        for (std::size_t d = 0; d < D; ++d) r += (point[d] - self[d]) * (point[d] - self[d]);
        sqrt_in_place(r);
        pair_value<D>(r, 2.0 / (self[D + 1] + point[D + 1]), w);
        pair.apply([&](Index j, double x) { return j == pair.i ? 0.0 : x; }, w);
        put(w, &value[pair.m]);
        take(&value[pair.m], w);
        row.sum[0] += w * point[D];
      },
      [&](std::size_t a, const auto& row) __attribute__((always_inline)) {
        const double sum = own(a) + sum_of_lanes(row.sum[0]);
        if (!(sum > 0.0)) return;
        parts[a] = amounts[a] / sum;
        amounts[a].setZero();
      });
  fill_copies(s.domain, std::span(parts).first(s.n_particles));
  for_each_in_lanes(
      s.n_real, s.worth_threads, [&](std::size_t a) __attribute__((always_inline)) {
        if (counts[a] == 0.0) return;
        VectorSum<D> sums;
        Lanes w{};
        for (std::size_t k = s.offset[a]; k < s.offset[a + 1]; k += n_lanes) {
          const Index* const i = &s.other[k];
          poretwin::take(&value[k], w);
          sums.add(w, {parts[i[0]].data(), parts[i[1]].data(), parts[i[2]].data(), parts[i[3]].data()});
        }
        Vec<D> sum = Kernel<D>::value(0.0, s.length(a)) * parts[a];
        for (int d = 0; d < D; ++d) sum[d] += sums.total(static_cast<std::size_t>(d));
        amounts[a] += counts[a] * sum;
      });
}

/// Entries of a Laplacian without buffers where all volumes are equal, all mobilities are equal, and `factor` is the
/// product of volume and mobility. The list's kernels are then equal for both particles of a pair.
template <int D>
void fill_even_laplacian(const Stencil<D>& s, double factor, PairMatrix& m) {
  ScalarArray amplified(s.size());
  parallel_for(s.size(), [&](std::size_t j) { amplified[j] = s.amplification[s.parent[j]]; });
  for_pairs<SumsOf<1>::Row>(
      s.rows(), PairInputs{amplified.data()},
      [&](const auto& pair, auto& own) __attribute__((always_inline)) {
        NumberOf<decltype(pair)> w, others;
        take(&s.gradient_factor[pair.m], w);
        gather_one(pair.rows(), 0, others);
        w *= factor * (*pair.self + others);
        if (s.beyond[pair.i] != 0) pair.apply([&](Index j, double x) { return s.parent[j] == pair.i ? 0.0 : x; }, w);
        put(w, &m.weight[pair.m]);
        take(&m.weight[pair.m], w);
        own.sum[0] += w;
      },
      [&](std::size_t a, const auto& own) __attribute__((always_inline)) { m.diagonal[a] = sum_of_lanes(own.sum[0]); });
}

/// Behind curved walls the images of b have other weights in row a than the images of a in row b. Both rows get the
/// mean of the two sums. The correction is added to the entry of the direct pair (a, b), which exists wherever one of
/// the particles sees an image of the other.
template <int D>
void make_symmetric(const Stencil<D>& s, PairMatrix& m) {
  std::vector<std::vector<std::pair<Index, double>>> by_images(s.n_real);  // for each row: whose images, and their sum
  parallel_for(s.n_real, [&](std::size_t a) {
    if (s.beyond[a] == 0) return;
    auto& row = by_images[a];
    for (std::size_t k = m.begin(a); k < m.end(a); ++k)
      if (s.other[k] >= s.n_base && m.weight[k] != 0.0F) row.emplace_back(s.parent[s.other[k]], m.weight[k]);
    std::sort(row.begin(), row.end());
    std::size_t last = 0;
    for (std::size_t i = 1; i < row.size(); ++i)
      if (row[i].first == row[last].first)
        row[last].second += row[i].second;
      else
        row[++last] = row[i];
    if (!row.empty()) row.resize(last + 1);
  });
  const auto seen = [&](std::size_t a, Index q) {
    const auto& row = by_images[a];
    const auto found = std::lower_bound(row.begin(), row.end(), std::pair(q, -HUGE_VAL));
    return found != row.end() && found->first == q ? found->second : 0.0;
  };
  parallel_for(s.n_real, [&](std::size_t a) {
    if (s.beyond[a] == 0) return;
    for (std::size_t k = m.begin(a); k < m.end(a); ++k) {
      const Index q = s.other[k];
      if (q >= s.n_real || q == a) continue;
      const double missing = 0.5 * (seen(q, static_cast<Index>(a)) - seen(a, q));
      m.weight[k] += static_cast<float>(missing);
      m.diagonal[a] += missing;
    }
  });
}

/// The numbers that laplacians() packs after a point's position: volume (0: not coupled), amplification, mobilities,
/// and in 3D the smoothing length, which would need a cube root. Row holds the data of a row of the matrix.
template <int D, std::size_t n_mobilities>
struct LaplacianRow {
  static constexpr std::size_t volume = D, amplified = D + 1, mobility = D + 2, at_length = mobility + n_mobilities;
  static constexpr std::size_t n_numbers = at_length - D + (D == 3 ? 1 : 0);
  template <class Number>
  [[gnu::always_inline]] static void length_of(const Number* point, Number& length) {
    if constexpr (D == 3) {
      length = point[at_length];
    } else {
      length = point[volume];
      sqrt_in_place(length);
      length = points::smoothing_ratio * length;
    }
  }
  template <class In>
  struct Row {
    typename In::Number sum[n_mobilities] = {};
    double faces = 0.0, length = 0.0;
    [[gnu::always_inline]] explicit Row(const double* self) { length_of(self, length); }
  };
};

/// V_a sum_b 2 V_b mobility_ab G_ab (p_a - p_b), G_ab = -W'/r: minus the Laplacian, weighted with the volume so that it
/// is symmetric. Returns one matrix for each of the mobilities of the real particles. Pairs get the harmonic mean; an
/// empty mobility is 1. All ranks call this. A pair with a buffer adds (1 + r) (p_a - p_face) to the diagonal, with the
/// reflection's ratio r of distances. Entries without a coupling have weight 0. The stencil must outlive the matrices.
template <int D, std::size_t n_mobilities>
std::array<PairMatrix, n_mobilities> laplacians(const Stencil<D>& s,
                                                const std::array<std::span<const double>, n_mobilities>& mobilities) {
  std::array<PairMatrix, n_mobilities> matrices;
  for (auto& m : matrices) {
    m.column = {s.offset, s.other, s.parent, s.beyond, s.n_particles};
    m.weight.resize(s.other.size());
    m.diagonal.resize(s.n_real);
  }
  const bool buffers = s.n_base > s.n_particles;
  std::vector<WithCopies<double>> everywhere;
  for (const auto mobility : mobilities) everywhere.push_back(mobility_with_copies(s, mobility));
  const auto same = [](std::span<const double> values) {
    return parallel_all(values.size(), [&](std::size_t a) { return values[a] == values[0]; });
  };
  // Both ranks of a pair must take the same way, for the two ways round weights differently.
  if (s.domain.all(!buffers && same(s.volume) && std::all_of(everywhere.begin(), everywhere.end(), same))) {
    for (std::size_t i = 0; i < n_mobilities && s.n_real > 0; ++i)
      fill_even_laplacian(s, s.volume[0] * (everywhere[i].empty() ? 1.0 : everywhere[i][0]), matrices[i]);
    if (s.uneven_images)
      for (auto& m : matrices) make_symmetric(s, m);
    return matrices;
  }
  using At = LaplacianRow<D, n_mobilities>;
  constexpr std::size_t n_numbers = At::n_numbers;
  // Without padding: the memory in use is largest here, beside the matrix.
  UnsetArray<PackedPoint<D, n_numbers, 1>> points(s.size());
  parallel_for(s.size(), [&](std::size_t j) {
    auto& x = points[j].x;
    x.fill(0.0);
    Eigen::Map<Vec<D>>{x.data()} = s.position[j];
    if constexpr (D == 3) x[At::at_length] = s.length(j);
    const Index q = s.parent[j];
    if (q >= s.n_particles) return;
    x[At::volume] = s.volume[j];
    x[At::amplified] = s.amplification[q];
    for (std::size_t i = 0; i < n_mobilities; ++i) x[At::mobility + i] = everywhere[i].empty() ? 1.0 : everywhere[i][q];
  });
  for_pairs<LaplacianRow<D, n_mobilities>::template Row>(
      s.rows(), PairInputs{points.data()},
      [&](const auto& pair, auto& own) __attribute__((always_inline)) {
        using Number = NumberOf<decltype(pair)>;
        const double* const self = pair.self;
        Number point[D + n_numbers];
        gather<0, D + n_numbers>(pair.rows(), point);
        if (buffers)
          pair.for_each([&](Index j, std::size_t k) {
            if (const Index q = s.parent[j]; q >= s.n_particles)
              own.faces += static_cast<double>(s.gradient_factor[k]) * s.reflection(pair.i, q);
          });
        // The kernel is computed again: the list's is rounded together with the volume of one of the pair's particles.
        Number r{}, scale, length, others{};
        for (std::size_t d = 0; d < D; ++d) r += (point[d] - self[d]) * (point[d] - self[d]);
        sqrt_in_place(r);
        At::length_of(point, length);
        pair_gradient_factor<D>(r, 2.0 / (own.length + length), scale);
        const bool beyond = s.beyond[pair.i] != 0;
        pair.apply([&](Index j, double) { return (beyond ? s.parent[j] : j) == pair.i ? 0.0 : 1.0; }, others);
        scale = (self[At::volume] * point[At::volume]) * (scale * (self[At::amplified] + point[At::amplified]));
        for (std::size_t m = 0; m < n_mobilities; ++m) {
          const Number& mobility = point[At::mobility + m];
          Number w, whole = self[At::mobility + m] + mobility;
          max_in_place(whole, Number{} + 1e-300);
          w = scale * (2.0 * self[At::mobility + m] * mobility / whole);
          w = others > 0.0 ? w : Number{};
          put(w, &matrices[m].weight[pair.m]);
          take(&matrices[m].weight[pair.m], w);
          own.sum[m] += w;
        }
      },
      [&](std::size_t a, const auto& own) __attribute__((always_inline)) {
        const double* const self = points[a].row();
        for (std::size_t m = 0; m < n_mobilities; ++m)
          matrices[m].diagonal[a] = sum_of_lanes(own.sum[m]) +
                                    2.0 * self[At::volume] * self[At::mobility + m] * self[At::amplified] * own.faces;
      });
  if (s.uneven_images)
    for (auto& m : matrices) make_symmetric(s, m);
  return matrices;
}

/// The matrix for one mobility.
template <int D>
PairMatrix laplacian(const Stencil<D>& s, std::span<const double> mobility) {
  return std::move(laplacians<D, 1>(s, {mobility})[0]);
}

}  // namespace poretwin::fluid
