// The water as others see it: particles, buffers behind faces and images behind walls, with their fields; interpolation
// in it.
#pragma once

#include "fluid_solver/state.hpp"
#include "fluid_solver/stencil.hpp"

#include <Eigen/Dense>

#include <limits>

namespace poretwin::fluid {

template <int D>
struct Cloud {
  std::size_t n_real = 0;
  VecArray<D> position;
  ScalarArray volume, length;
  ScalarArray owner;     ///< the particle an image belongs to; -1: a buffer, or its image
  ScalarArray pressure;  ///< total, Pa
  VecArray<D> velocity, solid_velocity;
  ScalarArray mask;
  [[nodiscard]] std::size_t size() const { return position.size(); }
};

template <int D>
Cloud<D> make_cloud(const State<D>& state, std::span<const sph::ImagePlane<D>> planes, const Vec<D>& weight,
                    const Vec<D>& origin) {
  const auto& p = state.particles;
  Cloud<D> c;
  c.n_real = p.size();
  c.position = p.position;
  c.volume = p.volume;
  c.pressure = p.pressure;
  c.velocity = p.velocity;
  c.solid_velocity = p.solid_velocity;
  c.mask = p.mask;
  for (const auto& b : make_buffers(state.columns)) {
    const auto& column = state.columns[b.column];
    c.position.push_back(b.position);
    c.volume.push_back(b.volume);
    c.pressure.push_back(column.pressure - column.slope * b.outside);
    c.velocity.push_back(column.speed * column.normal);
    c.solid_velocity.push_back(Vec<D>::Zero());
    c.mask.push_back(0.0);
  }
  double largest = 0.0;
  for (const double v : c.volume) {
    c.length.push_back(smoothing_ratio * std::pow(v, 1.0 / D));
    largest = std::max(largest, c.length.back());
  }
  for (std::size_t i = 0; i < c.size(); ++i) c.owner.push_back(i < c.n_real ? static_cast<double>(i) : -1.0);
  const VecArray<D> base = c.position;
  const auto images = sph::make_images<D>(base, planes, sph::support_radius * largest);
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Index q = images.parent[i];
    c.position.push_back(images.position[i]);
    c.volume.push_back(c.volume[q]);
    c.length.push_back(c.length[q]);
    c.owner.push_back(c.owner[q]);
    c.pressure.push_back(c.pressure[q]);
    c.velocity.push_back(images.map[i] * c.velocity[q]);
    c.solid_velocity.push_back(images.map[i] * c.solid_velocity[q]);
    c.mask.push_back(c.mask[q]);
  }
  for (std::size_t i = 0; i < c.size(); ++i) c.pressure[i] += weight.dot(c.position[i] - origin);
  return c;
}

/// Sum of V W at x over the cloud, of a lattice's: the degree of saturation there.
template <int D>
double saturation(const Cloud<D>& c, const Vec<D>& x) {
  double sum = 0.0;
  for (std::size_t j = 0; j < c.size(); ++j) {
    const double r2 = (c.position[j] - x).squaredNorm(), support = sph::support_radius * c.length[j];
    if (r2 < support * support) sum += c.volume[j] * Kernel<D>::value(std::sqrt(r2), c.length[j]);
  }
  return sum / lattice_fullness<D>();
}

/// Moving least squares of first order (weighted mean where the points do not span space); NaN outside the water.
template <int D, class Value>
double interpolate(const Cloud<D>& c, const Vec<D>& x, Value&& value) {
  using Row = Eigen::Matrix<double, D + 1, 1>;
  Eigen::Matrix<double, D + 1, D + 1> moment = Eigen::Matrix<double, D + 1, D + 1>::Zero();
  Row rhs = Row::Zero();
  for (std::size_t j = 0; j < c.size(); ++j) {
    const Vec<D> d = c.position[j] - x;
    const double r = d.norm();
    if (r >= sph::support_radius * c.length[j]) continue;
    const double w = c.volume[j] * Kernel<D>::value(r, c.length[j]);
    Row row;
    row[0] = 1.0;
    row.template tail<D>() = d / c.length[j];
    moment += w * row * row.transpose();
    rhs += w * value(j) * row;
  }
  if (moment(0, 0) < 0.3) return std::numeric_limits<double>::quiet_NaN();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, D + 1, D + 1>> eigen(moment);
  if (eigen.eigenvalues()[0] < 0.02 * moment(0, 0)) return rhs[0] / moment(0, 0);
  return moment.ldlt().solve(rhs)[0];
}

}  // namespace poretwin::fluid
