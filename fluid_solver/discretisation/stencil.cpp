#include "fluid_solver/discretisation/stencil.hpp"

#include "fluid_solver/boundary/inlet.hpp"

#include "common/core/in_lanes.hpp"
#include "common/geometry/surfaces.hpp"
#include "common/particles/neighbours.hpp"

#include <Eigen/Dense>

namespace poretwin::fluid {
namespace {

/// The data of a point that the sums over pairs read, packed together.
template <int D>
struct alignas(32) Summed {
  Vec<D> position;
  double volume, length;
  [[nodiscard]] const double* row() const { return position.data(); }
};

/// Rows of pairs found by one part of the search, for its share of the particles. Each object has cache lines of its
/// own, since lines that threads share are slow to write.
struct alignas(64) FoundRows {
  std::vector<Index> offset, other;
};

/// Finds for each point all points nearer than the mean of both supports; each row is padded to a multiple of four.
template <int D>
void find_pairs(double largest, Stencil<D>& s) {
  sph::CellGrid<D> grid;
  constexpr double reach = 0.5 * sph::support_radius;
  grid.build(s.position, reach * largest);
  UnsetArray<double> length(s.size());
  parallel_for(s.size(), [&](std::size_t j) { length[j] = s.length(j); });
  const bool even = parallel_all(s.size(), [&](std::size_t j) { return length[j] == largest; });
  s.beyond.resize(s.n_real);
  const auto find = [&](std::size_t first, std::size_t last, FoundRows & rows) __attribute__((always_inline)) {
    auto& [offset, other] = rows;
    other.reserve((last - first) * (D == 2 ? 28 : 96));
    offset.reserve(last - first);
    for (std::size_t a = first; a < last; ++a) {
      const double range = reach * (length[a] + largest);
      const std::size_t begin = other.size();
      if (even)
        grid.append_within(
            s.position[a], range, other, [&](Index j, double) __attribute__((always_inline)) { return j != a; });
      else
        grid.append_within(
            s.position[a], range, other, [&](Index j, double r2) __attribute__((always_inline)) {
              const double support = reach * (length[a] + length[j]);
              return static_cast<bool>(static_cast<int>(j != a) & static_cast<int>(r2 < support * support));
            });
      while (other.size() % n_lanes != 0) other.push_back(static_cast<Index>(a));
      Index highest = 0;
      for (std::size_t m = begin; m < other.size(); ++m) highest = std::max(highest, other[m]);
      s.beyond[a] = highest >= s.n_particles;
      offset.push_back(static_cast<Index>(other.size()));
    }
  };
  // In pieces: one array for all rows would need memory for the largest possible number of pairs.
  constexpr std::size_t piece = 16384;
  const std::size_t n_threads = parts_for(s.n_real, s.worth_threads),
                    parts = std::max(n_threads == 1 ? 1 : 4 * n_threads, s.n_real / piece);
  std::vector<FoundRows> found(parts);
  for_each_part(parts, [&](std::size_t part) {
    run_lanes([&]() __attribute__((always_inline)) {
      find(s.n_real * part / parts, s.n_real * (part + 1) / parts, found[part]);
    });
  });
  std::vector<Index> begin(parts + 1, 0);
  for (std::size_t part = 0; part < parts; ++part)
    begin[part + 1] = begin[part] + static_cast<Index>(found[part].other.size());
  s.offset.resize(s.n_real + 1);
  s.other.resize(begin[parts]);
  for_each_part(parts, [&](std::size_t part) {
    auto& [offset, other] = found[part];
    std::copy(other.begin(), other.end(), s.other.data() + begin[part]);
    std::transform(offset.begin(), offset.end(), s.offset.data() + s.n_real * part / parts + 1,
                   [&](Index end) { return begin[part] + end; });
    other = std::vector<Index>();
  });
}

/// At a crest, buffers behind the soil's face, which only water in soil sees, stand beside images behind the sill,
/// which only free water sees. Other pairs with them become pairs of the particle with itself, which are zero.
template <int D>
void part_ghosts(std::span<const Buffer<D>> buffers, std::span<const char> free, Stencil<D>& s) {
  const std::size_t n = s.n_real;
  std::vector<char> soils(s.size(), 0), sills(s.size(), 0);  // which points are ghosts of the two kinds
  bool any = false;
  for (std::size_t j = s.n_particles; j < s.size(); ++j) {
    const Index q = s.parent[j];
    soils[j] = q >= s.n_particles && buffers[q - s.n_particles].in_soil;
    sills[j] = j >= s.n_base && (s.boundaries[j - s.n_base] >> sill_boundary & 1u) != 0;
    any = any || soils[j] || sills[j];
  }
  if (!any) return;
  parallel_for(n, [&](std::size_t a) {
    if (s.beyond[a] == 0) return;
    const auto& hidden = free.empty() || free[a] ? soils : sills;
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k)
      if (hidden[s.other[k]]) s.other[k] = static_cast<Index>(a);
  });
}

/// Removes neighbours that walls hide: their pairs become pairs of the particle with itself, which are zero.
template <int D>
void hide_behind_walls(const sph::Sight<D>& sight, double reach, Stencil<D>& s) {
  parallel_ranges(s.n_real, s.worth_threads, [&](std::size_t first, std::size_t last) {
    typename sph::Sight<D>::Near near;
    for (std::size_t a = first; a < last; ++a) {
      sight.find_near(s.position[a], reach, near);
      if (near.empty() && s.beyond[a] == 0) continue;
      for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k)
        if (!sight.pairs(static_cast<Index>(a), s.other[k], s.n_base, s.position, s.by, s.of, near))
          s.other[k] = static_cast<Index>(a);
    }
  });
}

/// An image by walls of any shape is seen only from its original's side of the plane midway between the two.
template <int D>
void hide_from_behind(Stencil<D>& s) {
  if constexpr (D == 3) {
    parallel_for(s.n_real, [&](std::size_t a) {
      if (s.beyond[a] == 0) return;
      for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k)
        if (const Index j = s.other[k];
            j >= s.n_base && !Surfaces::sees(s.position[a], s.position[s.parent[j]], s.position[j]))
          s.other[k] = static_cast<Index>(a);
    });
  }
}

/// Where a wall ends at a face, removes pairs of a particle with an image behind the wall, if their line of sight
/// crosses the face, and with a buffer behind the face, if it crosses the wall. They become pairs of the particle with
/// itself, which are zero.
template <int D>
void part_at_joints(std::span<const Joint<D>> joints, double reach, Stencil<D>& s) {
  for (const auto& joint : joints) {
    // Images extend beyond the wall's end by a margin, and pairs by the kernel's reach.
    const double near = wall_margin * reach + reach, rounding = 1e-9 * reach;
    parallel_for(s.n_real, [&](std::size_t a) {
      if (s.beyond[a] == 0) return;
      const Vec<D> from = s.position[a] - joint.at;
      const double inside = joint.normal.dot(from), place = joint.along.dot(from);
      if (inside < -reach || inside > reach || std::abs(place) > near + reach) return;
      for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
        const Index j = s.other[k];
        if (j < s.n_particles) continue;
        const Vec<D> to = s.position[j] - joint.at;
        const double behind = joint.normal.dot(to);
        if (!(inside >= 0.0 && behind < 0.0)) continue;
        const double crossing = place + (joint.along.dot(to) - place) * inside / (inside - behind);
        const bool image = j >= s.n_base && (s.boundaries[j - s.n_base] >> joint.boundary & 1u) != 0;
        const bool by_wall = crossing <= rounding && crossing >= -joint.length;
        const bool by_face = crossing > rounding && crossing < near;
        if ((image && by_face) || (!image && s.is_buffer(j) && by_wall)) s.other[k] = static_cast<Index>(a);
      }
    });
  }
}

/// Marks open water: particles that no soil covers, and that have no particle covered by soil within reach. soilless
/// [particles]: 1 where no soil covers the particle; empty: no soil anywhere.
template <int D>
void mark_open_water(std::span<const char> soilless, Stencil<D>& s) {
  s.open_water.assign(s.n_real, 1);
  if (soilless.empty()) return;
  parallel_for(s.n_real, [&](std::size_t a) {
    bool open = soilless[a] != 0;
    for (Index k = s.offset[a]; k < s.offset[a + 1] && open; ++k)
      if (const Index q = s.parent[s.other[k]]; q < s.n_particles) open = soilless[q] != 0;
    s.open_water[a] = open ? 1 : 0;
  });
}

/// What sum_pairs() computes for a row: kernel sums, and the least ratio of distance to smoothing length.
template <int D>
struct KernelSums : SumsOf<2 + D + D*(D + 1) / 2> {
  using Sums = SumsOf<2 + D + D*(D + 1) / 2>;
  template <class In>
  struct Row : Sums::template Row<In> {
    typename In::Number least = typename In::Number{} + sph::support_radius;
    using Sums::template Row<In>::Row;
  };
};

/// Computes the kernels of all pairs and the sums over them; stores the moment matrices in place of the corrections.
/// by_density: the fullness of open water is measured with density_weight.
template <int D>
void sum_pairs(const Summed<D>* points, bool by_density, Stencil<D>& s) {
  static const double scale = Kernel<D>::normalisation(1.0);
  for_pairs<KernelSums<D>::template Row>(
      s.rows(), PairInputs{points},
      [&](const auto& pair, auto& own) __attribute__((always_inline)) {
        using Number = NumberOf<decltype(pair)>;
        const double* const self = pair.self;
        Number point[D + 2], ba[D], r{}, real{};
        gather<0, D + 2>(pair.rows(), point);
        pair.apply([&](Index j, double) { return j == pair.i ? 0.0 : scale; }, real);
        for (std::size_t d = 0; d < D; ++d) {
          ba[d] = point[d] - self[d];
          r += ba[d] * ba[d];
        }
        sqrt_in_place(r);
        const Number inverse = 2.0 / (self[D + 1] + point[D + 1]), q = r * inverse, square = inverse * inverse;
        Number u = 1.0 - 0.5 * q;
        min_in_place(own.least, real > 0.0 ? q : own.least);
        max_in_place(u, Number{});
        const Number cube = u * u * u * real * square * (D == 2 ? Number{} + 1.0 : inverse);
        const Number value = cube * u * (2.0 * q + 1.0);
        Number weight;
        density_weight(u, weight);
        weight *= real * square * (D == 2 ? Number{} + 1.0 : inverse);
        Number factor = 5.0 * square * cube * point[D];
        put(factor, &s.gradient_factor[pair.m]);
        take(&s.gradient_factor[pair.m], factor);
        std::size_t c = 0;
        own.sum[c++] += point[D] * value;
        own.sum[c++] += point[D] * weight;
        for (std::size_t d = 0; d < D; ++d) own.sum[c++] += factor * ba[d];
        for (std::size_t d = 0; d < D; ++d)
          for (std::size_t e = 0; e <= d; ++e) own.sum[c++] += factor * ba[d] * ba[e];
      },
      [&](std::size_t a, const auto& row) __attribute__((always_inline)) {
        double total[KernelSums<D>::size] = {};
        row.add_to(total);
        const double* next = total;
        s.closest[a] = least_of_lanes(row.least);
        static const double full = lattice_fullness<D>(),
                            full_density = lattice_density<D>() * Kernel<D>::normalisation(points::smoothing_ratio);
        const double own = points[a].volume * Kernel<D>::value(0.0, points[a].length),
                     fullness = (*next++ + own) / full;
        s.fullness[a] = by_density && s.open_water[a] != 0 ? (*next + own) / full_density : fullness;
        ++next;
        for (int d = 0; d < D; ++d) s.normal[a][d] = *next++;
        for (int d = 0; d < D; ++d)
          for (int e = 0; e <= d; ++e) s.correction[a](d, e) = s.correction[a](e, d) = *next++;
      });
}

}  // namespace

template <int D>
Mat<D> bounded_inverse(const Mat<D>& moment, double least, Mat<D>* unresolved, double* smallest) {
  // The least eigenvalue. In 3D a lower bound: as far below the mean as the other two eigenvalues allow.
  const double mean = moment.trace() / D;
  const double lower = mean - std::sqrt((D - 1.0) / D * (moment - mean * Mat<D>::Identity()).squaredNorm());
  if (lower >= least) {
    if (unresolved) unresolved->setZero();
    if (smallest && (D == 2 || lower >= points::inside_moment))
      *smallest = lower;
    else if (smallest)
      *smallest =
          Eigen::SelfAdjointEigenSolver<Mat<D>>().computeDirect(moment, Eigen::EigenvaluesOnly).eigenvalues()[0];
    return moment.inverse();
  }
  Eigen::SelfAdjointEigenSolver<Mat<D>> eigen;
  eigen.computeDirect(moment);
  Mat<D> inverse = Mat<D>::Zero();
  if (unresolved) unresolved->setZero();
  for (int d = 0; d < D; ++d) {
    const Mat<D> e = eigen.eigenvectors().col(d) * eigen.eigenvectors().col(d).transpose();
    const double value = eigen.eigenvalues()[d], held = std::max(value, least);
    inverse += e / held;
    if (unresolved) *unresolved += (1.0 - value / held) * e;
  }
  if (smallest) *smallest = eigen.eigenvalues()[0];
  return inverse;
}

template <int D>
sph::Images<D> images_of(std::span<const Vec<D>> points, std::span<const sph::ImagePlane<D>> planes,
                         const sph::Sight<D>& sight, const Surfaces* surfaces, double reach,
                         std::span<const Vec<D>> owners) {
  if constexpr (D == 3)
    if (surfaces) return surfaces->images(points, reach);
  return sight.limited() ? sph::images_in_all_orders<D>(points, sight.planes(), reach)
                         : sph::make_images<D>(points, planes, reach, owners);
}

template <int D>
Stencil<D> make_stencil(std::span<const Vec<D>> x, std::span<const double> volume, std::span<const Buffer<D>> buffers,
                        std::span<const sph::ImagePlane<D>> planes, std::span<const char> free, bool by_density,
                        std::size_t worth_threads, const sph::Sight<D>& sight, std::span<const Joint<D>> joints,
                        std::span<const char> soilless, const Surfaces* surfaces, const Domain& domain) {
  Stencil<D> s;
  s.domain = domain;
  s.worth_threads = worth_threads;
  s.n_particles = x.size();
  s.n_real = s.n_particles - domain.copies();
  s.n_base = s.n_particles + buffers.size();
  s.buffers.assign(buffers.begin(), buffers.end());
  VecArray<D> base(s.n_base), feet;
  std::copy(x.begin(), x.end(), base.begin());
  // The largest volume of all points, which determines the reach of images and pairs. Water behind faces is this
  // rank's.
  double largest = domain.max_over(volume.size(), 0.0, [&](std::size_t a) { return volume[a]; });
  for (std::size_t i = 0; i < buffers.size(); ++i) {
    base[s.n_particles + i] = buffers[i].position;
    feet.push_back(buffers[i].foot);
    largest = std::max(largest, buffers[i].volume);
  }
  largest = points::smoothing_ratio * spacing_of<D>(largest);
  const double reach = sph::support_radius * largest;
  auto images = images_of<D>(base, planes, sight, surfaces, reach, feet);
  s.uneven_images = surfaces != nullptr;
  const std::size_t all = s.n_base + images.size();
  s.position.resize(all);
  s.parent.resize(all);
  s.volume.resize(all);
  if (D == 3) s.smoothing.resize(all);
  parallel_for(all, [&](std::size_t i) {
    const std::size_t q = i < s.n_base ? i : images.parent[i - s.n_base];
    s.position[i] = i < s.n_base ? base[i] : images.position[i - s.n_base];
    s.parent[i] = static_cast<Index>(q);
    s.volume[i] = q < s.n_particles ? volume[q] : buffers[q - s.n_particles].volume;
    if (D == 3) s.smoothing[i] = points::smoothing_ratio * spacing_of<D>(s.volume[i]);
  });
  base = VecArray<D>();
  s.map = std::move(images.map);
  s.carried = std::move(images.carried);
  s.boundaries = std::move(images.boundaries);
  s.by = std::move(images.by);
  s.of = std::move(images.of);

  const std::size_t n = s.n_real;
  const auto exchange = [&] {
    fill_copies(s.domain, std::span(s.normal));
    fill_copies(s.domain, std::span(s.amplification));
  };
  if (n == 0) {
    exchange();  // other ranks may have water
    return s;
  }
  find_pairs(largest, s);
  part_ghosts(buffers, free, s);
  if (sight.limited()) hide_behind_walls(sight, reach, s);
  if (surfaces) hide_from_behind(s);
  part_at_joints(joints, reach, s);
  // The largest arrays are allocated first: smaller ones fit in between.
  s.gradient_factor.resize(s.other.size());
  for (auto* array : {&s.fullness, &s.closest, &s.divergence, &s.least_moment}) array->resize(n);
  s.amplification.resize(s.n_particles);
  s.normal.resize(s.n_particles);
  s.covered.assign(n, false);
  s.at_face.assign(n, false);
  s.correction.resize(n);
  s.boundary_correction_of.assign(n, 0);
  mark_open_water(soilless, s);
  UnsetArray<Summed<D>> points(s.size());
  parallel_for(s.size(), [&](std::size_t j) { points[j] = {s.position[j], s.volume[j], s.length(j)}; });
  sum_pairs<D>(points.data(), by_density, s);
  constexpr char surface = 1, face = 2;
  std::vector<char> edge(n, 0);
  parallel_for(n, [&](std::size_t a) {
    const Mat<D> moment = s.correction[a];
    s.divergence[a] = moment.trace();
    // For a quadratic, the pair Laplacian is wrong by the kernel's second moment, 2.6 % on a lattice at this smoothing
    // length, and so would be the rate of consolidation. A value far from 1 means a surface, and not disorder.
    const double deficit = s.divergence[a] / D;
    s.amplification[a] =
        1.0 /
        (deficit > points::disorder_from ? std::clamp(deficit, points::least_amplified, points::most_amplified) : 1.0);
    s.correction[a] = bounded_inverse<D>(moment, points::least_inverted, nullptr, &s.least_moment[a]);
    for (Index k = s.offset[a]; s.beyond[a] != 0 && k < s.offset[a + 1]; ++k)
      if (s.is_buffer(s.other[k])) edge[a] = face;
    if (s.least_moment[a] < points::least_inverted) edge[a] |= surface;
  });
  for (std::size_t a = 0; a < n; ++a)
    if (edge[a] != 0) s.boundary_correction(a);
  const auto fill_edge = [&](std::size_t a) {
    if ((edge[a] & surface) != 0)
      bounded_inverse<D>(s.moment(a), points::least_inverted, &s.boundary_correction(a).unresolved);
    if ((edge[a] & face) == 0) return;
    Mat<D> open = Mat<D>::Zero();
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
      const Index j = s.other[k];
      const Vec<D> ba = s.position[j] - s.position[a];
      if (!s.is_buffer(j)) open += static_cast<double>(s.gradient_factor[k]) * ba * ba.transpose();
    }
    s.boundary_correction(a).open = bounded_inverse<D>(open, points::least_inverted, nullptr);
  };
  parallel_ranges(n, s.worth_threads, [&](std::size_t first, std::size_t last) {
    for (std::size_t a = first; a < last; ++a)
      if (edge[a] != 0) fill_edge(a);
  });
  exchange();
  return s;
}

#define PORETWIN_INSTANTIATE(D)                                                                                      \
  template Mat<D> bounded_inverse<D>(const Mat<D>&, double, Mat<D>*, double*);                                       \
  template Stencil<D> make_stencil<D>(std::span<const Vec<D>>, std::span<const double>, std::span<const Buffer<D>>,  \
                                      std::span<const sph::ImagePlane<D>>, std::span<const char>, bool, std::size_t, \
                                      const sph::Sight<D>&, std::span<const Joint<D>>, std::span<const char>,        \
                                      const Surfaces*, const Domain&);                                               \
  template sph::Images<D> images_of<D>(std::span<const Vec<D>>, std::span<const sph::ImagePlane<D>>,                 \
                                       const sph::Sight<D>&, const Surfaces*, double, std::span<const Vec<D>>);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::fluid
