#include "fluid_solver/stencil.hpp"

#include "common/sph/neighbours.hpp"

#include <Eigen/Dense>

namespace poretwin::fluid {
namespace {

/// Least eigenvalue of a moment that is inverted in full: gradients in directions with fewer neighbours are taken
/// short rather than amplified.
constexpr double least_inverted = 0.3;

}  // namespace

template <int D>
Mat<D> bounded_inverse(const Mat<D>& moment, double least, Mat<D>* blind, double* smallest) {
  if constexpr (D == 2) {
    const double mean = 0.5 * moment.trace(), half = 0.5 * (moment(0, 0) - moment(1, 1));
    const double lower = mean - std::sqrt(half * half + moment(0, 1) * moment(1, 0));
    if (lower >= least) {
      if (blind) blind->setZero();
      if (smallest) *smallest = lower;
      return moment.inverse();
    }
  }
  Eigen::SelfAdjointEigenSolver<Mat<D>> eigen;
  eigen.computeDirect(moment);
  Mat<D> inverse = Mat<D>::Zero();
  if (blind) blind->setZero();
  for (int d = 0; d < D; ++d) {
    const Mat<D> e = eigen.eigenvectors().col(d) * eigen.eigenvectors().col(d).transpose();
    const double value = eigen.eigenvalues()[d], held = std::max(value, least);
    inverse += e / held;
    if (blind) *blind += (1.0 - value / held) * e;
  }
  if (smallest) *smallest = eigen.eigenvalues()[0];
  return inverse;
}

template <int D>
Stencil<D> make_stencil(std::span<const Vec<D>> x, std::span<const double> volume, std::span<const Buffer<D>> buffers,
                        std::span<const sph::ImagePlane<D>> planes) {
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
    s.length.push_back(smoothing_ratio * spacing_of<D>(v));
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
  s.carried = std::move(images.carried);
  s.boundaries = std::move(images.boundaries);

  const std::size_t n = s.n_real;
  s.fullness.assign(n, 0.0);
  s.divergence.assign(n, 0.0);
  s.amplification.assign(n, 1.0);
  s.normal.assign(n, Vec<D>::Zero());
  s.surface_pressure.assign(n, 0.0);
  s.covered.assign(n, false);
  s.surface_distance.resize(n);
  for (std::size_t a = 0; a < n; ++a) s.surface_distance[a] = 0.5 * spacing_of<D>(volume[a]);
  s.correction.resize(n);
  s.correction_open.resize(n);
  s.blind.resize(n);
  s.moment.resize(n);
  s.least_moment.assign(n, 0.0);
  s.ghost_distance.assign(n, 0.0);
  if (n == 0) return s;
  sph::CellGrid<D> grid;
  const double reach = 0.5 * sph::support_radius;
  grid.build(s.position, reach * largest);
  s.offset.reserve(n + 1);
  const std::size_t pairs = n * (D == 2 ? 24 : 80);
  s.other.reserve(pairs);
  s.value.reserve(pairs);
  s.strength.reserve(pairs);
  s.gradient.reserve(pairs);
  if (!buffers.empty()) s.reflection.reserve(pairs);
  const double full = lattice_fullness<D>();
  for (std::size_t a = 0; a < n; ++a) {
    Mat<D> moment = Mat<D>::Zero(), moment_open = Mat<D>::Zero();
    double sum = s.volume[a] * Kernel<D>::value(0.0, s.length[a]);
    grid.for_each_within(s.position[a], reach * (s.length[a] + largest), [&](Index j, double r2) {
      const double h = 0.5 * (s.length[a] + s.length[j]);
      if (j == a || r2 >= 4.0 * h * h) return;
      const auto [w, g] = Kernel<D>::pair(std::sqrt(r2), h);
      const Vec<D> ba = s.position[j] - s.position[a];
      const bool buffer = s.is_buffer(j);
      s.other.push_back(j);
      s.value.push_back(w);
      s.strength.push_back(g);
      s.gradient.push_back(g * ba);
      if (buffer) {
        const auto& b = buffers[s.parent[j] - n];
        const double inside = b.normal.dot(s.position[a] - b.foot), outside = b.outside;
        s.reflection.push_back(1.0 + (30.0 * inside <= outside ? 30.0 : outside / inside));
      } else if (!buffers.empty()) {
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
    s.moment[a] = moment;
    s.correction[a] = bounded_inverse<D>(moment, least_inverted, &s.blind[a], &s.least_moment[a]);
    s.correction_open[a] = n == s.n_base ? s.correction[a] : bounded_inverse<D>(moment_open, least_inverted, nullptr);
    s.offset.push_back(static_cast<Index>(s.other.size()));
  }
  return s;
}

#define PORETWIN_INSTANTIATE(D)                                                                                     \
  template Mat<D> bounded_inverse<D>(const Mat<D>&, double, Mat<D>*, double*);                                      \
  template Stencil<D> make_stencil<D>(std::span<const Vec<D>>, std::span<const double>, std::span<const Buffer<D>>, \
                                      std::span<const sph::ImagePlane<D>>);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::fluid
