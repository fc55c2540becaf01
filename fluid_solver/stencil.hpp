// The particles' surroundings at one instant: real particles, buffer particles outside prescribed-pressure faces, and
// the images of both behind walls and periodic sides; pairs, kernel gradients and their corrections.
#pragma once

#include "common/core/vector.hpp"
#include "common/sph/images.hpp"
#include "common/sph/kernel.hpp"
#include "common/sph/neighbours.hpp"

#include <Eigen/Dense>

#include <span>

namespace poretwin::fluid {

template <int D>
using Kernel = sph::WendlandC2<D>;

/// Smoothing length in units of the cube root (2D: square root) of the bulk volume.
inline constexpr double smoothing_ratio = 1.3;

/// Sum of V W over an infinite square lattice: what "full" means for a particle.
template <int D>
double lattice_fullness() {
  static const double value = [] {
    double sum = 0.0;
    const int reach = 3;
    for (int i = -reach; i <= reach; ++i)
      for (int j = -reach; j <= reach; ++j)
        for (int k = (D == 3 ? -reach : 0); k <= (D == 3 ? reach : 0); ++k)
          sum += Kernel<D>::value(std::sqrt(1.0 * (i * i + j * j + k * k)), smoothing_ratio);
    return sum;
  }();
  return value;
}

/// A buffer particle stands for the water behind a face: it has no unknown of its own, its pressure lies on the
/// straight line from the particle that asks through the face's pressure.
template <int D>
struct Buffer {
  Vec<D> position;
  double volume = 0.0;   ///< m^D
  Index column = 0;      ///< of the face columns
  double outside = 0.0;  ///< distance from the face [m]
};

template <int D>
struct Stencil {
  std::size_t n_real = 0, n_base = 0;     ///< real particles; with buffers
  VecArray<D> position;                   ///< [all]
  ScalarArray volume, length;             ///< [all] V [m^D], h [m]
  std::vector<Index> parent;              ///< [all] base point an image belongs to; itself for base points
  MatArray<D> map;                        ///< [images] linear part for vectors
  std::vector<std::uint32_t> boundaries;  ///< [images]
  std::vector<Index> column;              ///< [base - real] face column of each buffer
  ScalarArray outside;                    ///< [base - real] distance from its face [m]

  /// Slope of the pressure at each face column, a straight line through the face's pressure fitted to the particles
  /// inside: slope = sum fit_weight (p - p_face) over fit_index[fit_offset[c] .. fit_offset[c + 1]); none where the
  /// ground is dry.
  std::vector<Index> fit_offset{0}, fit_index;
  ScalarArray fit_weight;  ///< 1/m

  std::vector<Index> offset{0};  ///< pairs of real a: offset[a] .. offset[a + 1]
  std::vector<Index> other;      ///< [pairs]
  VecArray<D> gradient;          ///< [pairs] grad_a W_ab, 1/m^(D+1)
  ScalarArray strength;          ///< [pairs] -W'/r, 1/m^(D+2)
  ScalarArray value;             ///< [pairs] W, 1/m^D
  ScalarArray reflection;        ///< [pairs] 0, or 1 + |d_b|/d_a where b is a buffer

  ScalarArray fullness;    ///< [real] sum V W over that of a lattice
  ScalarArray divergence;  ///< [real] sum V div r: D inside
  ScalarArray
      amplification;       ///< [real] of pair sums of second derivatives, to make them exact for a quadratic on average
  VecArray<D> normal;      ///< [real] sum V grad W: inward where the surroundings are one-sided, 1/m
  MatArray<D> correction;  ///< [real] of the kernel gradient, buffers counted (pressures)
  MatArray<D> correction_open;  ///< [real] buffers left out (velocities)
  MatArray<D> blind;            ///< [real] projector on directions in which there are no neighbours to difference with

  /// Of the pair of real particle a with a point whose parent is q.
  [[nodiscard]] double amplified(std::size_t a, Index q) const {
    return 0.5 * (amplification[a] + amplification[q < n_real ? q : a]);
  }
  [[nodiscard]] bool is_buffer(Index j) const { return parent[j] >= n_real && parent[j] < n_base; }
  [[nodiscard]] std::size_t size() const { return position.size(); }
};

/// Inverse of a kernel moment matrix on the directions it can see; the others are left out and returned as a projector.
template <int D>
Mat<D> pseudo_inverse(const Mat<D>& moment, double threshold, Mat<D>* blind) {
  Eigen::SelfAdjointEigenSolver<Mat<D>> eigen;
  eigen.computeDirect(moment);
  Mat<D> inverse = Mat<D>::Zero();
  if (blind) blind->setZero();
  for (int d = 0; d < D; ++d) {
    const Vec<D> e = eigen.eigenvectors().col(d);
    if (eigen.eigenvalues()[d] > threshold)
      inverse += e * e.transpose() / eigen.eigenvalues()[d];
    else if (blind)
      *blind += e * e.transpose();
  }
  return inverse;
}

/// distance(column, x): how far x lies inside the column's face [m].
template <int D, class Distance>
Stencil<D> make_stencil(std::span<const Vec<D>> x, std::span<const double> volume, std::span<const Buffer<D>> buffers,
                        std::span<const sph::ImagePlane<D>> planes, Distance&& distance) {
  Stencil<D> s;
  s.n_real = x.size();
  s.n_base = s.n_real + buffers.size();
  s.position.assign(x.begin(), x.end());
  s.volume.assign(volume.begin(), volume.end());
  for (const auto& b : buffers) {
    s.position.push_back(b.position);
    s.volume.push_back(b.volume);
    s.column.push_back(b.column);
    s.outside.push_back(b.outside);
  }
  double largest = 0.0;
  for (const double v : s.volume) {
    s.length.push_back(smoothing_ratio * std::pow(v, 1.0 / D));
    largest = std::max(largest, s.length.back());
  }
  for (std::size_t i = 0; i < s.n_base; ++i) s.parent.push_back(static_cast<Index>(i));
  const VecArray<D> base = s.position;
  auto images = sph::make_images<D>(base, planes, sph::support_radius * largest);
  for (std::size_t i = 0; i < images.size(); ++i) {
    s.position.push_back(images.position[i]);
    s.parent.push_back(images.parent[i]);
    s.volume.push_back(s.volume[images.parent[i]]);
    s.length.push_back(s.length[images.parent[i]]);
  }
  s.map = std::move(images.map);
  s.boundaries = std::move(images.boundaries);

  const std::size_t n = s.n_real;
  s.fullness.assign(n, 0.0);
  s.divergence.assign(n, 0.0);
  s.amplification.assign(n, 1.0);
  s.normal.assign(n, Vec<D>::Zero());
  s.correction.resize(n);
  s.correction_open.resize(n);
  s.blind.resize(n);
  if (n == 0) return s;
  sph::CellGrid<D> grid;
  const double reach = 0.5 * sph::support_radius;
  grid.build(s.position, 2.0 * reach * largest);
  s.offset.reserve(n + 1);
  const double full = lattice_fullness<D>();
  for (std::size_t a = 0; a < n; ++a) {
    Mat<D> moment = Mat<D>::Zero(), moment_open = Mat<D>::Zero();
    double sum = s.volume[a] * Kernel<D>::value(0.0, s.length[a]);
    grid.for_each_within(s.position[a], reach * (s.length[a] + largest), [&](Index j, double r2) {
      const double h = 0.5 * (s.length[a] + s.length[j]);
      if (j == a || r2 >= 4.0 * h * h) return;
      const double r = std::sqrt(r2), w = Kernel<D>::value(r, h), g = -Kernel<D>::derivative_over_r(r, h);
      const Vec<D> ba = s.position[j] - s.position[a];
      const bool buffer = s.is_buffer(j);
      s.other.push_back(j);
      s.value.push_back(w);
      s.strength.push_back(g);
      s.gradient.push_back(g * ba);
      if (buffer) {
        const Index c = s.column[s.parent[j] - n];
        const double inside = distance(c, s.position[a]);
        const double outside = buffers[s.parent[j] - n].outside;
        s.reflection.push_back(1.0 + (30.0 * inside <= outside ? 30.0 : outside / inside));
      } else {
        s.reflection.push_back(0.0);
      }
      const double v = s.volume[j];
      sum += v * w;
      s.normal[a] += v * g * ba;
      const Mat<D> outer = v * g * ba * ba.transpose();
      moment += outer;
      if (!buffer) moment_open += outer;
    });
    s.fullness[a] = sum / full;
    s.divergence[a] = moment.trace();
    // The pair Laplacian of a quadratic is off by the kernel's moment, 2.6 % on a lattice at this smoothing length:
    // that much too fast or slow a consolidation. Far from 1 it means a surface, not disorder.
    const double deficit = s.divergence[a] / D;
    s.amplification[a] = 1.0 / (deficit > 0.75 ? std::clamp(deficit, 0.93, 1.07) : 1.0);
    s.correction[a] = pseudo_inverse<D>(moment, 0.05, &s.blind[a]);
    s.correction_open[a] = pseudo_inverse<D>(moment_open, 0.05, nullptr);
    s.offset.push_back(static_cast<Index>(s.other.size()));
  }
  return s;
}

}  // namespace poretwin::fluid
