// The SPH operators of the skeleton as free functions on plain arrays. Exactness first: gradients are exact for linear
// fields, and the internal force is the exact adjoint of the velocity gradient, so that internal forces do the work
// that strains store, to rounding.
#pragma once

#include "common/particles/kernel.hpp"
#include "solid_solver/numerics/points.hpp"
#include "solid_solver/state.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <span>

namespace poretwin::solid {

/// Strengths of the stabilising terms.
struct Stabilisers {
  /// Hourglass control: a viscosity on the part of the velocity that is not linear around a particle, and a stiffness,
  /// as a fraction of M, on that part of the displacement.
  double hourglass_viscosity = points::hourglass_viscosity, hourglass_stiffness = points::hourglass_stiffness;
  /// Largest stress of that stiffness in soil that has yielded, as a fraction of sqrt(J2).
  double held = points::hourglass_bound;
  double modulus = 0.0;                              ///< Pa, M
  double artificial = points::artificial_viscosity;  ///< alpha of Monaghan's artificial viscosity
  double quadratic = 0.0;                            ///< beta of the same
  double bulk = 0.0;               ///< m2/s, against changes of volume away from surfaces (linear, Landshoff 1955)
  double artificial_stress = 0.0;  ///< epsilon, in tension
  double collision = points::collision_viscosity;  ///< the same where grains that are apart collide: inelastically
  double sound_speed = 0.0;                        ///< m/s
  double step = 0.0;                               ///< s, in which no collision may throw back
};

/// Inverse with the eigenvalues held above a floor.
template <int D>
[[gnu::noinline]] Mat<D> invert_above(const Mat<D>& moment, double floor) {
  Eigen::SelfAdjointEigenSolver<Mat<D>> solver;
  solver.computeDirect(moment);
  const Vec<D> inverse = solver.eigenvalues().cwiseMax(floor).cwiseInverse();
  return solver.eigenvectors() * inverse.asDiagonal() * solver.eigenvectors().transpose();
}

/// Inverse of M = -sum V F r r^T with its eigenvalues held above a floor: particles that are nearly alone keep a
/// bounded gradient. Corners of a lattice lie above it, so that they stay exact.
template <int D>
inline Mat<D> invert_moment(const Mat<D>& moment) {
  constexpr double floor = D == 2 ? points::least_inverted_2d : points::least_inverted_3d;
  bool above = false;
  if constexpr (D == 2) {
    // The lowest eigenvalue lies above the floor when both of M - floor I are positive.
    const double a = moment(0, 0) - floor, b = moment(1, 1) - floor;
    above = a + b > 0.0 && a * b > moment(0, 1) * moment(0, 1);
  } else {
    // The lowest eigenvalue is at least det / (trace / 2)^2.
    const double half = 0.5 * moment.trace();
    above = moment.determinant() > floor * half * half;
  }
  Mat<D> inverse;
  if (above) {
    inverse = moment.inverse();
  } else {
    // Copied element by element: if the call's result were assigned to `inverse`, the compiler would keep `inverse` in
    // memory instead of registers on the frequent branch, too.
    const Mat<D> held = invert_above<D>(moment, floor);
    for (int c = 0; c < D * D; ++c) inverse.data()[c] = held.data()[c];
  }
  return inverse;
}

/// W'/r of the pairs of the rows from `first` on.
template <int D>
void pair_kernels(const std::vector<Node<D>>& nodes, const Pairs& pairs, double h, std::size_t first, Kernels& kernel);

/// Corrected velocity gradient, Eqs. (88), (89) made exact for linear fields near images and free surfaces alike;
/// the correction B it needs comes with it. Of the particles' nodes; those of images follow in fill_nodes.
template <int D>
void velocity_gradient(const Pairs& pairs, const Kernels& kernel, std::vector<Node<D>>& nodes);

/// Internal force per volume, the exact adjoint of velocity_gradient (cf. Eq. (60)):
///   f_i = sum_j V_j (sigma_i B_i + sigma_j B_j) grad W_ij.   Node::flux holds sigma B.
/// With it goes a stiffness on the part of the displacement that a linear field does not explain: it resists
/// hourglass modes for good (a viscosity only slows them) and leaves every uniform strain alone. In soil that has
/// yielded it yields as well, at a small share of the soil's own shear stress (Node::hourglass_level): it cannot act as
/// strength there. Apart, per volume: the same as a viscosity, and artificial viscosity on approaching pairs; where
/// grains that are apart collide, more of it and with Coulomb's friction (it would else carry thin sheets without any:
/// 23 degrees instead of 31). Every pair's force is V_i V_j times what is opposite for its two particles, hence
/// momentum is kept. Forces of the first n_free particles, which have these displacements [m]; kernels of their rows
/// are left in `kernel`.
template <int D>
void internal_force(const std::vector<Node<D>>& nodes, const Neighbourhood<D>& near, const VecArray<D>& displacement,
                    std::size_t n_free, double h, const Stabilisers& stabilisers, Kernels& kernel,
                    std::vector<Force<D>>& force);

/// Artificial stress of Gray, Monaghan & Swift (2001) [N/m3]: close pairs in tension repel one another,
///   f_i = sum_j V_j (W(r)/W(dx))^n (R_i + R_j) grad W_ij,   n = 2.55,
/// R = -epsilon times the tensile principal stresses. Of the first n_free particles; added to `force`.
template <int D>
void add_artificial_stress(const State<D>& state, double epsilon, double spacing, double h, VecArray<D>& force) {
  const std::size_t n = state.particles.size();
  MatArray<D> repulsion(n);
  for (std::size_t i = 0; i < n; ++i) {
    Eigen::SelfAdjointEigenSolver<Mat<D>> solver;
    solver.computeDirect(matrix_of<D>(state.particles.stress[i]));
    const Vec<D> tension = solver.eigenvalues().cwiseMax(0.0);
    repulsion[i] = -epsilon * solver.eigenvectors() * tension.asDiagonal() * solver.eigenvectors().transpose();
  }
  const double laid = sph::WendlandC2<D>::value(spacing, h);
  for_each_ordered_pair(state.near.pairs, [&](std::size_t i, std::size_t j, std::size_t m) {
    if (i >= state.particles.free()) return;
    Mat<D> both = repulsion[i];
    if (j < n) {
      both += repulsion[j];
    } else {
      const auto& rule = state.near.images[j - n];
      both += rule.map * repulsion[rule.parent] * rule.map.transpose();
    }
    const Vec<D> r = state.nodes[i].position - state.nodes[j].position;
    const double closeness =
        std::pow(sph::WendlandC2<D>::value(r.norm(), h) / laid, points::artificial_stress_exponent);
    force[i] += (state.nodes[j].volume * closeness * state.kernel[m]) * (both * r);
  });
}

/// The correction B of a particle or of an image, that of its parent mirrored as geometry.
template <int D>
Mat<D> correction_at(const State<D>& state, std::size_t j) {
  const std::size_t n = state.particles.size();
  if (j < n) return state.nodes[j].correction();
  const auto& rule = state.near.images[j - n];
  return rule.map * state.nodes[rule.parent].correction() * rule.map.transpose();
}

/// q_i = sum_j V_j (B_i + B_j) grad W_ij [1/m], B of images mirrored as geometry: zero inside, -(outward normal) times
/// a surface delta function at a free surface. The force of a uniform stress S is S q, so a traction T acts as -T (n .
/// q).
template <int D>
VecArray<D> surface_vectors(const State<D>& state) {
  const std::size_t n = state.particles.size();
  VecArray<D> q(n, Vec<D>::Zero());
  for_each_ordered_pair(state.near.pairs, [&](std::size_t i, std::size_t j, std::size_t m) {
    const Mat<D> other = correction_at(state, j);
    const Vec<D> w = (state.nodes[j].volume * state.kernel[m]) * (state.nodes[i].position - state.nodes[j].position);
    q[i] += (state.nodes[i].correction() + other) * w;
  });
  return q;
}

/// Pore-pressure gradient at the soil's own points [Pa/m], Eq. (62) with the corrected sign, per n_s: differences
/// p_j - p_i, kernel-gradient corrected, hence exact for linear pressure (buoyancy) and independent of the water's
/// surface. Real particles and periodic images only: what the water does behind a wall the soil cannot know.
template <int D>
VecArray<D> pressure_gradient_difference(const State<D>& state, std::span<const double> pressure);

/// Pore-pressure gradient [Pa/m] below a loaded face, in the adjoint form that the stress has: the load is carried by
/// stress and pressure alike, row by row, however sharply the pressure falls at the face. pressure: over that beyond
/// the face. Written to the particles given.
template <int D>
void pressure_gradient_adjoint(const State<D>& state, std::span<const double> pressure,
                               const std::vector<Index>& particles, VecArray<D>& gradient) {
  const std::size_t n = state.particles.size();
  std::vector<char> wanted(n, 0);
  for (const Index i : particles) {
    wanted[i] = 1;
    gradient[i].setZero();
  }
  for_each_ordered_pair(state.near.pairs, [&](std::size_t i, std::size_t j, std::size_t m) {
    if (!wanted[i]) return;
    const std::size_t source = j < n ? j : state.near.images[j - n].parent;
    const Mat<D> other = correction_at(state, j);
    const Vec<D> w = (state.nodes[j].volume * state.kernel[m]) * (state.nodes[i].position - state.nodes[j].position);
    gradient[i] += (pressure[i] * state.nodes[i].correction() + pressure[source] * other) * w;
  });
}

/// Pore-pressure gradient of Eq. (61): sum_j m_j rho_i (p_i/rho_i^2 + p_j/rho_j^2) grad W [Pa/m]. It takes a free soil
/// surface for a jump of the water's pressure to zero and expels the particles there; kept to show that. Images carry
/// the hydrostatic mirror p' = p + rho_w g . (x' - x).
template <int D>
VecArray<D> pressure_gradient_sum(const State<D>& state, std::span<const double> pressure, const Vec<D>& water_weight) {
  const std::size_t n = state.particles.size();
  VecArray<D> gradient(n, Vec<D>::Zero());
  for_each_ordered_pair(state.near.pairs, [&](std::size_t i, std::size_t j, std::size_t m) {
    const std::size_t source = j < n ? j : state.near.images[j - n].parent;
    double p = pressure[source];
    if (j >= n && !state.near.images[j - n].periodic)
      p += water_weight.dot(state.nodes[j].position - state.nodes[source].position);
    const Node<D>&a = state.nodes[i], &b = state.nodes[j];
    const double own = pressure[i] / (a.density * a.density), theirs = p / (b.density * b.density);
    gradient[i] += (b.volume * b.density * a.density * (own + theirs) * state.kernel[m]) * (a.position - b.position);
  });
  return gradient;
}

}  // namespace poretwin::solid
