// The neighbourhoods of the particles at one instant: pairs, kernel gradients and their corrections. The points are
// real particles, buffer particles outside faces of prescribed pressure, and images behind walls and periodic sides.
#pragma once

#include "common/core/lanes.hpp"
#include "common/core/or_zero.hpp"
#include "common/core/unset.hpp"
#include "common/core/vector.hpp"
#include "common/particles/domain.hpp"
#include "common/particles/for_pairs.hpp"
#include "common/particles/images.hpp"
#include "common/particles/kernel.hpp"
#include "common/particles/sight.hpp"
#include "fluid_solver/numerics/points.hpp"

#include <optional>
#include <span>

namespace poretwin {
class Surfaces;
}

namespace poretwin::fluid {

template <int D>
using Kernel = sph::WendlandC2<D>;

/// Edge [m] of a square or cube of this volume: the spacing of particles on a lattice.
template <int D>
double spacing_of(double volume) {
  if constexpr (D == 2) return std::sqrt(volume);
  // Most particles have the same volume, and cube roots are slow.
  thread_local double last = 0.0, root = 0.0;
  if (volume != last) {
    root = std::cbrt(volume);
    last = volume;
  }
  return root;
}

/// Sum of part(distance) over the points within reach on an infinite square (3D: cubic) lattice of unit spacing,
/// including the point itself.
template <int D, class Part>
double lattice_sum(Part part) {
  double sum = 0.0;
  const int reach = 3;
  for (int i = -reach; i <= reach; ++i)
    for (int j = -reach; j <= reach; ++j)
      for (int k = (D == 3 ? -reach : 0); k <= (D == 3 ? reach : 0); ++k)
        sum += part(std::sqrt(1.0 * (i * i + j * j + k * k)));
  return sum;
}

/// Sum of V W on a lattice: the fullness of water is measured relative to it.
template <int D>
double lattice_fullness() {
  static const double value = lattice_sum<D>([](double r) { return Kernel<D>::value(r, points::smoothing_ratio); });
  return value;
}

/// Weight of a point in the density of open water (2D), with u = 1 - r / support; it is 1 at the point itself. It is
/// nearly Hann's window. Its spectrum is close to zero where that of a packing is not, so that the sum hardly depends
/// on the order of the points: at a jitter of 0.2 spacings the sum is 0.3 % above a lattice's (sum V W: 1.5 %), in
/// flowing water 0.0 % (sum V W: 0.4 %). In 3D it would depend on the order as well (0.3 %).
template <class Number>
[[gnu::always_inline]] inline void density_weight(const Number& u, Number& weight) {
  weight = u * u * (3.0 - 2.0 * u);
}

/// Sum of density_weight over a lattice, or over the lattice planes that lie `distance` spacings or more away on one
/// side.
template <int D>
double lattice_density(std::optional<double> distance = {}) {
  constexpr double support = sph::support_radius * points::smoothing_ratio;
  constexpr int reach = 3;
  double sum = 0.0, weight = 0.0;
  for (double z = distance.value_or(-reach); z < support; z += 1.0)
    for (int i = -reach; i <= reach; ++i)
      for (int j = (D == 3 ? -reach : 0); j <= (D == 3 ? reach : 0); ++j) {
        density_weight(std::max(0.0, 1.0 - std::sqrt(z * z + i * i + j * j) / support), weight);
        sum += weight;
      }
  return sum;
}

/// Factor that makes pair sums of second derivatives exact inside a lattice.
template <int D>
double lattice_amplification() {
  static const double value =
      D / lattice_sum<D>([](double r) {
        return r > 0.0 ? -r * Kernel<D>::derivative_over_r(r, points::smoothing_ratio) * r : 0.0;
      });
  return value;
}

/// -W'/r [1/m^(D+2)] of a pair at distance r; inverse: of the pair's smoothing length. It is zero beyond the support.
template <int D, class Number>
[[gnu::always_inline]] inline void pair_gradient_factor(const Number& r, const Number& inverse, Number& factor) {
  static const double scale = 5.0 * Kernel<D>::normalisation(1.0);
  const Number square = inverse * inverse;
  Number u = 1.0 - 0.5 * (r * inverse);
  max_in_place(u, Number{});
  factor = scale * (u * u * u) * (square * square) * (D == 2 ? Number{} + 1.0 : inverse);
}

/// W [1/m^D] of a pair at distance r; inverse: of the pair's smoothing length.
template <int D, class Number>
[[gnu::always_inline]] inline void pair_value(const Number& r, const Number& inverse, Number& value) {
  static const double scale = Kernel<D>::normalisation(1.0);
  const Number q = r * inverse;
  Number u = 1.0 - 0.5 * q;
  max_in_place(u, Number{});
  value = scale * (u * u) * (u * u) * (2.0 * q + 1.0) * (inverse * inverse) * (D == 2 ? Number{} + 1.0 : inverse);
}

/// Loops over the pairs of at least this number of particles use several threads. One thread takes some 0.4 ms for the
/// loop over 8192 particles, for water that runs alone, and 0.1 ms for 2048, where the other processes of a coupled run
/// wait for it. To wake a thread takes some 0.02 ms, and between two loops the thread is idle: a tenth less wall time
/// costs a sixth more CPU time.
inline constexpr std::size_t worth_threads_in_pairs = 8192, worth_threads_while_others_wait = 2048;

/// Length by which the images behind a wall continue beyond its end, in units of the kernel's reach.
inline constexpr double wall_margin = points::wall_overhang / (sph::support_radius * points::smoothing_ratio);

/// A buffer particle represents the water behind a face. It has no unknown of its own: its pressure lies on the
/// straight line between the pressure of the particle whose row is summed and the face's pressure.
template <int D>
struct Buffer {
  Vec<D> position;
  double volume = 0.0;                                    ///< m^D
  Index column = 0;                                       ///< index of its face column
  double outside = 0.0;                                   ///< m, distance from the face
  Vec<D> foot = Vec<D>::Zero(), normal = Vec<D>::Zero();  ///< m, foot of its column on the face; unit normal into the
                                                          ///< domain
  bool in_soil = false;                                   ///< the ground in front of the face is soil
  [[nodiscard]] double inside(const Vec<D>& x) const { return normal.dot(x - foot); }
};

/// The end of a wall at which a face with columns begins, straight on or turned away from the domain. What lies behind
/// the wall and behind the face continues without end. For two points on either side of the wall's line, that one of
/// the two applies which their line of sight crosses. It is the same for both points, so that the matrix stays
/// symmetric and no point is seen twice.
template <int D>
struct Joint {
  Vec<D> at = Vec<D>::Zero();                              ///< m
  Vec<D> along = Vec<D>::Zero(), normal = Vec<D>::Zero();  ///< unit vectors: along the wall's line, away from the wall;
                                                           ///< into the domain
  double length = 0.0;                                     ///< m, of the wall's piece
  int boundary = 0;                                        ///< boundary number of the wall
};

/// Lengths of the arrays: [all] points, [real] particles of this rank, [particles] these and copies of other ranks'
/// particles, [base] particles and buffers, [images], [pairs] entries of the pair lists, [columns] of the faces. Each
/// begins with the points of those before it, so that an index names the same point in all.
template <int D>
struct Stencil {
  Domain domain;                            ///< its owned particles are the real ones
  std::size_t n_real = 0;                   ///< number of real particles, which have rows of pairs
  std::size_t n_particles = 0, n_base = 0;  ///< number of particles with copies; number of particles and buffers
  std::size_t worth_threads = worth_threads_in_pairs;
  VecArray<D> position;                   ///< [all]
  ScalarArray volume;                     ///< [all] V, m^D
  ScalarArray smoothing;                  ///< [all] h, m; in 3D only, where cube roots are slow
  std::vector<Index> parent;              ///< [all] base point to which an image belongs; a base point itself
  MatArray<D> map;                        ///< [images] linear map for vectors
  VecArray<D> carried;                    ///< [images] m/s, added to velocities: 2 U n behind a piston of speed U
  std::vector<std::uint32_t> boundaries;  ///< [images] boundaries passed, one bit for each
  std::vector<Index> by, of;              ///< [images] see sph::Images; only where lines of sight are limited
  bool uneven_images = false;             ///< walls have any shape: two particles see different images of each other
  std::vector<Buffer<D>> buffers;         ///< [base - particles]

  /// Slope of the pressure at each face column: that of a straight line through the face's pressure, fitted to the
  /// particles inside. slope = sum fit_weight (p - p_face) over fit_index[fit_offset[c] .. fit_offset[c + 1]) of all
  /// ranks (face_slopes).
  std::vector<Index> fit_offset{0}, fit_index;
  ScalarArray fit_weight;    ///< 1/m
  ScalarArray fit_constant;  ///< [columns] Pa/m, added to the slope of a pressure, but not to that of an increment
  std::vector<char> fitted;  ///< [columns] 1 where there are such particles; 0: the ground is dry

  /// The pairs of real particle a are entries offset[a] .. offset[a + 1]. Their number is a multiple of four: they are
  /// padded with a itself, whose terms are zero.
  std::vector<Index> offset{0};
  UnsetArray<Index> other;   ///< [pairs] the other point
  std::vector<char> beyond;  ///< [real] 1 if some of its pairs are with points that are not particles
  /// [pairs] -V_b W'/r, 1/m^2: V_b grad_a W_ab is this factor times (r_b - r_a). Single precision halves the memory.
  /// Moments are sums of the rounded values, so that gradients of linear fields stay exact.
  UnsetArray<float> gradient_factor;

  std::vector<char> open_water;      ///< [real] 1 if no soil covers the particle or any other within its kernel's reach
  UnsetArray<double> fullness;       ///< [real] sum V W, or sum V density_weight, over the sum of a lattice
  UnsetArray<double> closest;        ///< [real] least distance from another point, over the pair's smoothing length
  UnsetArray<double> divergence;     ///< [real] sum V div r: D inside; used until the surface is found
  UnsetArray<double> amplification;  ///< [particles] factor on pair sums of second derivatives; makes them exact for a
                                     ///< quadratic on average
  VecArray<D> normal;  ///< [particles] 1/m, sum V grad W: points inwards where neighbours are missing on one side
  std::vector<char> covered;  ///< [real] in soil, with water in the cone outwards: loose packing, not a surface
  std::vector<char> at_face;  ///< [real] in soil, within half a spacing of a seepage face, at which the water ends
  /// [particles] Prescribed distance of a surface particle from the surface [m]; 0: half a spacing.
  OrZero<double> prescribed_surface_distance;
  OrZero<double> surface_pressure;  ///< [particles] Pa, total pressure on the surface: 0, or a suction
  MatArray<D> correction;           ///< [real] of the kernel gradient of pressures; with buffers and the free surface
  /// [real] Smallest eigenvalue of the moment matrix: 1 inside, 0 where a direction has no neighbours. A value above
  /// points::inside_moment may be a lower bound of the eigenvalue. Used until the surface is found.
  UnsetArray<double> least_moment;
  /// [real] Distance from the free surface along -normal [m]; 0: out of the kernel's reach. Set by find_surface. A
  /// ghost at twice this distance replaces the missing part of the kernel, antisymmetric about the surface's pressure.
  OrZero<double> ghost_distance;
  /// [real] For seeping water below the row of surface particles: distance from the surface along -normal [m]; 0: out
  /// of the kernel's reach. Set by find_surface. Where it is set, the surface's pressure also enters the Laplacian.
  OrZero<double> front_distance;
  /// [all] Kind of surface particle to which a point belongs: 1 of free water, 2 of seeping water, 0: the point belongs
  /// to no surface particle. Set by find_surface.
  std::vector<char> on_surface;

  /// Corrections of a particle's gradients where its kernel's support is cut off, at a surface or a face. Other
  /// particles need none.
  struct BoundaryCorrection {
    Mat<D> open;        ///< correction without buffers and the free surface (velocities)
    Mat<D> unresolved;  ///< 1 - correction times moment: projects on directions with too few neighbours for a gradient
  };
  std::vector<Index> boundary_correction_of;  ///< [real] 1 + index in boundary_corrections; 0: inside
  std::vector<BoundaryCorrection> boundary_corrections;
  [[nodiscard]] const Mat<D>& correction_open(std::size_t a) const {
    return boundary_correction_of[a] == 0 ? correction[a] : boundary_corrections[boundary_correction_of[a] - 1].open;
  }
  /// The boundary correction of particle a. A particle that has none gets one, initialised with its `correction`.
  BoundaryCorrection& boundary_correction(std::size_t a) {
    if (boundary_correction_of[a] == 0) {
      boundary_corrections.push_back({correction[a], Mat<D>::Zero()});
      boundary_correction_of[a] = static_cast<Index>(boundary_corrections.size());
    }
    return boundary_corrections[boundary_correction_of[a] - 1];
  }

  /// A field of the real particles, with its values at the copies.
  template <class T>
  [[nodiscard]] WithCopies<T> with_copies(std::span<const T> field) const {
    return {domain, field.first(n_real)};
  }
  /// Flags of the real particles, 0 or 1, with those of the copies; all ranks call this.
  [[nodiscard]] std::vector<char> flags_with_copies(std::span<const char> own) const {
    std::vector<char> all(own.begin(), own.end());
    if (domain.alone()) return all;
    const ScalarArray numbers(own.begin(), own.end());
    const auto filled = with_copies<double>(numbers);
    all.resize(n_particles);
    for (std::size_t q = n_real; q < n_particles; ++q) all[q] = filled[q] != 0.0 ? 1 : 0;
    return all;
  }
  /// Brings the values at the copies of a field [particles] up to date; all ranks call this.
  void fill_copies(OrZero<double>& field) const {
    if (domain.alone() || !domain.any(field.is_allocated())) return;
    if (!field.is_allocated()) field.allocate(n_particles);
    poretwin::fill_copies(domain, std::span(field.values()));
  }

  /// Smoothing length h [m] of any point.
  [[nodiscard]] double length(std::size_t j) const {
    return D == 3 ? smoothing[j] : points::smoothing_ratio * spacing_of<D>(volume[j]);
  }
  /// Distance of a surface particle from the surface [m].
  [[nodiscard]] double surface_distance(std::size_t a) const {
    return prescribed_surface_distance[a] > 0.0 ? prescribed_surface_distance[a] : 0.5 * spacing_of<D>(volume[a]);
  }
  /// Frees the arrays that are used only until the surface has been found.
  void forget_moments() {
    for (auto* array : {&divergence, &least_moment}) *array = UnsetArray<double>();
  }

  /// W of real particle a and any point [1/m^D]; 0 for the particle itself, which pads the rows.
  [[nodiscard]] double value(std::size_t a, Index j) const {
    if (j == a) return 0.0;
    return Kernel<D>::value((position[j] - position[a]).norm(), 0.5 * (length(a) + length(j)));
  }
  /// sum V r grad W of real particle a. The correction is the inverse of this matrix.
  [[nodiscard]] Mat<D> moment(std::size_t a) const {
    Mat<D> sum = Mat<D>::Zero();
    for (Index k = offset[a]; k < offset[a + 1]; ++k) {
      const Vec<D> ba = position[other[k]] - position[a];
      sum += static_cast<double>(gradient_factor[k]) * ba * ba.transpose();
    }
    return sum;
  }

  /// Amplification (`amplification`) of the pair of real particle a and a point with parent q: the mean of both.
  [[nodiscard]] double amplified(std::size_t a, Index q) const {
    return 0.5 * (amplification[a] + amplification[q < n_particles ? q : a]);
  }
  /// 1 + |d_b|/d_a for the pair of real particle a and a point whose parent q is a buffer, with the distances d of both
  /// from the face. The value is bitwise the same wherever it is evaluated.
  [[nodiscard, gnu::noinline]] double reflection(std::size_t a, Index q) const {
    const auto& b = buffers[q - n_particles];
    const double inside = b.inside(position[a]);
    return static_cast<float>(
        1.0 + (points::most_reflected * inside <= b.outside ? points::most_reflected : b.outside / inside));
  }
  /// Whether point j is an image behind one of these walls (one bit for each wall).
  [[nodiscard]] bool sticks(std::size_t j, std::uint32_t sticky) const {
    return j >= n_base && (boundaries[j - n_base] & sticky) != 0;
  }
  [[nodiscard]] bool is_buffer(Index j) const { return parent[j] >= n_particles && parent[j] < n_base; }
  /// Whether a face column has a slope of the pressure.
  [[nodiscard]] bool has_slope(Index column) const { return column < fitted.size() && fitted[column] != 0; }
  [[nodiscard]] std::size_t size() const { return position.size(); }
  /// The pair lists for for_pairs().
  [[nodiscard]] FullRows rows() const { return {offset.data(), other.data(), n_real, worth_threads}; }
};

/// Inverse of a symmetric moment matrix, after its eigenvalues are raised to at least `least`. unresolved: 1 - inverse
/// times moment, the directions that stay unresolved; smallest: the smallest eigenvalue, as in Stencil::least_moment.
template <int D>
Mat<D> bounded_inverse(const Mat<D>& moment, double least, Mat<D>* unresolved, double* smallest = nullptr);

/// The images of points behind all walls that the case has, up to `reach` [m] behind the walls. owners: as for
/// sph::make_images; those of buffers are their feet, since a buffer itself may lie behind the wall that continues its
/// face.
template <int D>
sph::Images<D> images_of(std::span<const Vec<D>> points, std::span<const sph::ImagePlane<D>> planes,
                         const sph::Sight<D>& sight, const Surfaces* surfaces, double reach,
                         std::span<const Vec<D>> owners = {});

/// Neighbourhoods of the particles at x [m] with their bulk volumes [m^D], buffers outside faces, and images behind
/// planes. domain: how many of these particles, the last ones, are copies. free [real]: 1 for particles in no soil, 0
/// for others; empty: all are free. Water in soil does not see images
/// behind a sill; free water does not see buffers behind a face of soil. by_density: fullness of open water is measured
/// with density_weight. worth_threads: number of particles from which on loops use several threads. sight: where it is
/// limited, its planes make the images. joints: of walls and faces; images and buffers beyond them are seen as far as
/// lines of sight reach. soilless [particles]: 1 for particles that no soil covers, not even in part; empty: all.
/// surfaces: walls of any shape and planes (3D), which replace the planes.
template <int D>
Stencil<D> make_stencil(std::span<const Vec<D>> x, std::span<const double> volume, std::span<const Buffer<D>> buffers,
                        std::span<const sph::ImagePlane<D>> planes, std::span<const char> free = {},
                        bool by_density = false, std::size_t worth_threads = worth_threads_in_pairs,
                        const sph::Sight<D>& sight = {}, std::span<const Joint<D>> joints = {},
                        std::span<const char> soilless = {}, const Surfaces* surfaces = nullptr,
                        const Domain& domain = {});

}  // namespace poretwin::fluid
