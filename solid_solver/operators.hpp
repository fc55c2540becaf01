// The SPH operators of the skeleton as free functions on plain arrays. Exactness first: gradients are exact for linear
// fields, and the internal force is the exact adjoint of the velocity gradient, so that internal forces do the work
// that strains store, to rounding.
#pragma once

#include "common/sph/kernel.hpp"
#include "solid_solver/state.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <span>

namespace poretwin::solid {

/// Strengths of the stabilising terms.
struct Stabilisers {
  double zero_energy = 0.1;  ///< hg: viscosity on the part of the velocity that is not linear around a particle
  double stiffness = 0.1;    ///< the same on the displacement, of M, between particles that never yielded
  double modulus = 0.0;      ///< Pa, M
  double artificial = 0.1;   ///< alpha of Monaghan's artificial viscosity
  double sound_speed = 0.0;  ///< m/s
};

/// Inverse of M = -sum V F r r^T with its eigenvalues held above a floor: particles that are nearly alone keep a
/// bounded gradient. Corners of a lattice lie above it, so that they stay exact.
template <int D>
Mat<D> invert_moment(const Mat<D>& moment) {
  constexpr double floor = D == 2 ? 0.2 : 0.1;
  if constexpr (D == 2) {
    const double half = 0.5 * (moment(0, 0) + moment(1, 1));
    const double lowest = half - std::hypot(0.5 * (moment(0, 0) - moment(1, 1)), moment(0, 1));
    if (lowest > floor) return moment.inverse();
  } else {
    // The lowest eigenvalue is at least det / (trace / 2)^2.
    const double half = 0.5 * moment.trace();
    if (moment.determinant() > floor * half * half) return moment.inverse();
  }
  Eigen::SelfAdjointEigenSolver<Mat<D>> solver;
  solver.computeDirect(moment);
  const Vec<D> inverse = solver.eigenvalues().cwiseMax(floor).cwiseInverse();
  return solver.eigenvectors() * inverse.asDiagonal() * solver.eigenvectors().transpose();
}

/// W'/r of all pairs at the nodes' current positions.
template <int D>
void pair_kernels(const std::vector<Node<D>>& nodes, const sph::PairList& pairs, double h, ScalarArray& kernel) {
  kernel.resize(pairs.index.size());
  const double scale = -5.0 * sph::WendlandC2<D>::normalisation(h) / (h * h), half_inverse = 0.5 / h;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Vec<D> x = nodes[i].position;
    for (Index m = pairs.offset[i]; m < pairs.offset[i + 1]; ++m) {
      const double u = std::max(0.0, 1.0 - half_inverse * (x - nodes[pairs.index[m]].position).norm());
      kernel[m] = scale * u * u * u;
    }
  }
}

/// Corrected velocity gradient, Eqs. (88), (89) made exact for linear fields near images and free surfaces alike;
/// the correction B it needs comes with it.
template <int D>
void velocity_gradient(const std::vector<Node<D>>& nodes, const sph::PairList& pairs, const ScalarArray& kernel,
                       MatArray<D>& gradient, MatArray<D>& deformation, MatArray<D>& correction) {
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Vec<D> x = nodes[i].position, v = nodes[i].velocity, u = nodes[i].displacement;
    Mat<D> moment = Mat<D>::Zero(), raw = Mat<D>::Zero(), moved = Mat<D>::Zero();
    for (Index m = pairs.offset[i]; m < pairs.offset[i + 1]; ++m) {
      const Node<D>& other = nodes[pairs.index[m]];
      const Vec<D> r = x - other.position;
      const Vec<D> w = (other.volume * kernel[m]) * r;
      raw.noalias() += (other.velocity - v) * w.transpose();
      moved.noalias() += (other.displacement - u) * w.transpose();
      moment.noalias() -= r * w.transpose();
    }
    correction[i] = invert_moment<D>(moment);
    gradient[i].noalias() = raw * correction[i];
    deformation[i].noalias() = moved * correction[i];
  }
}

/// Internal force per volume, the exact adjoint of velocity_gradient (cf. Eq. (60)):
///   f_i = sum_j V_j (sigma_i B_i + sigma_j B_j) grad W_ij.   Node::flux holds V sigma B.
/// With it goes a stiffness on the part of the displacement that a linear field does not explain: it resists
/// zero-energy modes for good (a viscosity only slows them) and leaves every uniform strain alone. Apart, per volume:
/// the same as a viscosity, and artificial viscosity on approaching pairs.
template <int D>
void internal_force(const std::vector<Node<D>>& nodes, const sph::PairList& pairs, const ScalarArray& kernel, double h,
                    const Stabilisers& stabilisers, VecArray<D>& internal, VecArray<D>& stabilising) {
  const double control = stabilisers.zero_energy * stabilisers.sound_speed * h;
  const double stiffness = stabilisers.stiffness * stabilisers.modulus;
  const double viscosity = stabilisers.artificial * stabilisers.sound_speed * h;
  const double clip = 0.01 * h * h;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Node<D>& self = nodes[i];
    const Vec<D> x = self.position, v = self.velocity;
    const Mat<D> gradient = self.gradient, deformation = self.deformation;
    const Vec<D> moved = self.displacement;
    const double own_inverse = self.inverse_density, own_control = 0.5 * control * self.control;
    Vec<D> force = Vec<D>::Zero(), surface = Vec<D>::Zero(), viscous = Vec<D>::Zero(), elastic = Vec<D>::Zero();
    for (Index m = pairs.offset[i]; m < pairs.offset[i + 1]; ++m) {
      const Node<D>& other = nodes[pairs.index[m]];
      const double k = kernel[m];
      const Vec<D> r = x - other.position, u = v - other.velocity;
      const Vec<D> w = k * r;
      force.noalias() += other.flux * w;
      surface += other.volume * w;
      // m_j / 2 (1/rho_i + 1/rho_j): symmetric in the pair once multiplied by m_i, hence momentum is kept.
      const double share = k * (other.mass * own_inverse + other.volume);
      const Vec<D> rest = u - 0.5 * ((gradient + other.gradient) * r);
      viscous += (own_control * other.control * share) * rest;
      if (self.elastic && other.elastic)
        elastic += (k * other.volume) * (moved - other.displacement - 0.5 * ((deformation + other.deformation) * r));
      const double approach = u.dot(r);
      if (approach < 0.0) viscous += (0.5 * viscosity * share * approach / (r.squaredNorm() + clip)) * r;
    }
    internal[i] = force + (self.flux / self.volume) * surface + stiffness * elastic;
    stabilising[i] = viscous / own_inverse;
  }
}

/// q_i = sum_j V_j (B_i + B_j) grad W_ij [1/m], B of images mirrored as geometry: zero inside, -(outward normal) times
/// a surface delta function at a free surface. The force of a uniform stress S is S q, so a traction T acts as -T (n .
/// q).
template <int D>
VecArray<D> surface_vectors(const State<D>& state) {
  const auto& pairs = state.near.pairs;
  const std::size_t n = state.particles.size();
  VecArray<D> q(n, Vec<D>::Zero());
  for (std::size_t i = 0; i < n; ++i)
    for (Index m = pairs.offset[i]; m < pairs.offset[i + 1]; ++m) {
      const std::size_t j = pairs.index[m];
      Mat<D> other;
      if (j < n) {
        other = state.particles.correction[j];
      } else {
        const auto& rule = state.near.images[j - n];
        other = rule.map * state.particles.correction[rule.parent] * rule.map.transpose();
      }
      const Vec<D> w = (state.nodes[j].volume * state.kernel[m]) * (state.nodes[i].position - state.nodes[j].position);
      q[i] += (state.particles.correction[i] + other) * w;
    }
  return q;
}

/// Pore-pressure gradient at the soil's own points [Pa/m], Eq. (62) with the corrected sign, per n_s: differences
/// p_j - p_i, kernel-gradient corrected, hence exact for linear pressure (buoyancy) and blind to the water's surface.
/// Real particles and periodic images only: what the water does behind a wall the soil cannot know.
template <int D>
VecArray<D> pressure_gradient_difference(const State<D>& state, std::span<const double> pressure) {
  const auto& pairs = state.near.pairs;
  const std::size_t n = state.particles.size();
  VecArray<D> gradient(n, Vec<D>::Zero());
  for (std::size_t i = 0; i < n; ++i) {
    Mat<D> moment = Mat<D>::Zero();
    Vec<D> raw = Vec<D>::Zero();
    for (Index m = pairs.offset[i]; m < pairs.offset[i + 1]; ++m) {
      const std::size_t j = pairs.index[m];
      std::size_t source = j;
      if (j >= n) {
        if (!state.near.images[j - n].periodic) continue;
        source = state.near.images[j - n].parent;
      }
      const Vec<D> r = state.nodes[i].position - state.nodes[j].position;
      const Vec<D> w = (state.nodes[j].volume * state.kernel[m]) * r;
      raw += (pressure[source] - pressure[i]) * w;
      moment -= r * w.transpose();
    }
    gradient[i] = invert_moment<D>(moment) * raw;
  }
  return gradient;
}

/// Pore-pressure gradient of Eq. (61): sum_j m_j rho_i (p_i/rho_i^2 + p_j/rho_j^2) grad W [Pa/m]. It takes a free soil
/// surface for a jump of the water's pressure to zero and expels the particles there; kept to show that. Images carry
/// the hydrostatic mirror p' = p + rho_w g . (x' - x).
template <int D>
VecArray<D> pressure_gradient_sum(const State<D>& state, std::span<const double> pressure, const Vec<D>& water_weight) {
  const auto& pairs = state.near.pairs;
  const std::size_t n = state.particles.size();
  VecArray<D> gradient(n, Vec<D>::Zero());
  for (std::size_t i = 0; i < n; ++i)
    for (Index m = pairs.offset[i]; m < pairs.offset[i + 1]; ++m) {
      const std::size_t j = pairs.index[m];
      const std::size_t source = j < n ? j : state.near.images[j - n].parent;
      double p = pressure[source];
      if (j >= n && !state.near.images[j - n].periodic)
        p += water_weight.dot(state.nodes[j].position - state.nodes[source].position);
      const Node<D>&a = state.nodes[i], &b = state.nodes[j];
      const double own = pressure[i] * a.inverse_density * a.inverse_density;
      const double theirs = p * b.inverse_density * b.inverse_density;
      gradient[i] += (b.mass / a.inverse_density * (own + theirs) * state.kernel[m]) * (a.position - b.position);
    }
  return gradient;
}

}  // namespace poretwin::solid
