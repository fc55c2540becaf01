// The SPH operators of the skeleton, as free functions on plain arrays. Gradients are exact for linear fields. The
// internal force is the exact adjoint of the velocity gradient. Hence the work of internal forces equals, to rounding,
// the work that strains store.
#pragma once

#include "common/particles/kernel.hpp"
#include "solid_solver/numerics/exchange.hpp"
#include "solid_solver/numerics/points.hpp"
#include "solid_solver/state.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <span>

namespace poretwin::solid {

/// Coefficients of the stabilising terms.
struct Stabilisers {
  /// Hourglass control: a viscosity against the part of the velocity that is not linear around a particle, and a
  /// stiffness, as a fraction of M, against the same part of the displacement.
  double hourglass_viscosity = points::hourglass_viscosity, hourglass_stiffness = points::hourglass_stiffness;
  /// Largest stress of the hourglass stiffness in soil that has yielded, as a fraction of sqrt(J2).
  double held = points::hourglass_bound;
  double modulus = 0.0;                              ///< Pa, constrained modulus M
  double artificial = points::artificial_viscosity;  ///< alpha of Monaghan's artificial viscosity
  double quadratic = 0.0;                            ///< beta of Monaghan's artificial viscosity
  double bulk = 0.0;               ///< m2/s, viscosity against changes of volume, away from surfaces (linear, Landshoff
                                   ///< 1955)
  double artificial_stress = 0.0;  ///< epsilon of the artificial stress in tension
  double collision = points::collision_viscosity;  ///< alpha where grains that are apart collide; makes collisions
                                                   ///< inelastic
  double sound_speed = 0.0;                        ///< m/s
  double step = 0.0;                               ///< s, substep in which a collision must not throw particles back
};

/// Inverse of a symmetric matrix whose eigenvalues below `floor` are raised to `floor`.
template <int D>
[[gnu::noinline]] Mat<D> invert_above(const Mat<D>& moment, double floor) {
  Eigen::SelfAdjointEigenSolver<Mat<D>> solver;
  solver.computeDirect(moment);
  const Vec<D> inverse = solver.eigenvalues().cwiseMax(floor).cwiseInverse();
  return solver.eigenvectors() * inverse.asDiagonal() * solver.eigenvectors().transpose();
}

/// Inverse of the moment M = -sum V F r r^T (F = W'/r). Its eigenvalues are raised to a floor, so that particles that
/// are nearly alone have a bounded gradient. The corners of a lattice lie above the floor and stay exact.
template <int D>
inline Mat<D> invert_moment(const Mat<D>& moment) {
  constexpr double floor = D == 2 ? points::least_inverted_2d : points::least_inverted_3d;
  bool above = false;
  if constexpr (D == 2) {
    // The lowest eigenvalue exceeds the floor when both eigenvalues of M - floor I are positive.
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
    // Copied element by element: an assignment would make the compiler keep `inverse` in memory, not in registers, on
    // the frequent branch as well.
    const Mat<D> held = invert_above<D>(moment, floor);
    for (int c = 0; c < D * D; ++c) inverse.data()[c] = held.data()[c];
  }
  return inverse;
}

/// Sets W'/r [1/m^(D+2)] of the pairs in row `first` and the rows after it.
template <int D>
void pair_kernels(const std::vector<Node<D>>& nodes, const Pairs& pairs, double h, std::size_t first, Kernels& kernel);

/// Sets the velocity gradient [1/s] and the correction B of the particles' nodes: Eqs. (88), (89), corrected so that
/// linear fields are exact both near images and at free surfaces. fill_nodes sets the values of images.
template <int D>
void velocity_gradient(const Pairs& pairs, const Kernels& kernel, std::vector<Node<D>>& nodes);

/// Internal force per volume [N/m3], the exact adjoint of velocity_gradient (cf. Eq. (60)):
///   f_i = sum_j V_j (sigma_i B_i + sigma_j B_j) grad W_ij, Node::flux = sigma B.
/// The internal force includes a stiffness against the part of the displacement that is not linear around a particle.
/// This stiffness resists hourglass modes permanently, while a viscosity only slows them. It does not affect uniform
/// strain. In soil that has yielded, the stress of this stiffness is limited to a small fraction of the soil's shear
/// stress (Node::hourglass_level), so that it does not act as strength.
///
/// The second part of each force, also per volume, contains the hourglass viscosity and an artificial viscosity between
/// approaching particles. Where grains that are apart collide, the artificial viscosity is larger, and Coulomb's
/// friction acts; without this friction thin sheets would have too little friction (23 degrees instead of 31).
///
/// The forces of a pair on its two particles are V_i V_j times opposite vectors, so that momentum is conserved.
/// displacement [m]: of all particles. Forces are computed for the first n_free particles, and the kernels of their
/// rows are stored in `kernel`. pairs: the pairs that count, of the particles and of the given images.
template <int D>
void internal_force(const std::vector<Node<D>>& nodes, const Pairs& pairs, const std::vector<ImageRule<D>>& images,
                    const VecArray<D>& displacement, std::size_t n_free, double h, const Stabilisers& stabilisers,
                    Kernels& kernel, std::vector<Force<D>>& force);
/// The internal force of all pairs in reach.
template <int D>
void internal_force(const std::vector<Node<D>>& nodes, const Neighbourhood<D>& near, const VecArray<D>& displacement,
                    std::size_t n_free, double h, const Stabilisers& stabilisers, Kernels& kernel,
                    std::vector<Force<D>>& force) {
  internal_force<D>(nodes, near.pairs, near.images, displacement, n_free, h, stabilisers, kernel, force);
}

/// Adds to `force` the internal force that acts on particles as parents of images behind walls of any shape. A particle
/// i that sees an image of j exerts a force on j by the adjoint of the image's velocity map T,
///   f_j -= sum_i V_i (V_j' / V_j) T^T (sigma_i B_i) grad W_ij',
/// with the image's volume V'. Behind planes this is the mirrored stress of the images of i that j sees. slip: see
/// Particles.
template <int D>
void pull_back(const std::vector<Node<D>>& nodes, const Neighbourhood<D>& near, const Kernels& kernel,
               const VecArray<D>& slip, std::vector<Force<D>>& force);

/// Computes the gradient of the displacement anew at particles with images behind curved walls, from the displacements
/// of only the particles around them. It is exact for linear fields. If integrated in time, this gradient would drift
/// as soil slides along such walls, and so would the stiffness against hourglass modes.
template <int D>
void refit_deformation(const Particles<D>& particles, const Neighbourhood<D>& near, double h,
                       std::vector<Node<D>>& nodes);

/// Artificial stress of Gray, Monaghan & Swift (2001) [N/m3]. It makes close particles in tension repel each other:
///   f_i = sum_j V_j (W(r)/W(dx))^n (R_i + R_j) grad W_ij, n = 2.55,
/// with R = -epsilon times the tensile part of the stress. Added to `force` for the free particles.
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

/// The correction B of a particle or of an image. The correction of an image is that of its parent, mirrored.
template <int D>
Mat<D> correction_at(const State<D>& state, std::size_t j) {
  const std::size_t n = state.particles.with_copies();
  if (j < n) return state.nodes[j].correction();
  const auto& rule = state.near.images[j - n];
  return rule.map * state.nodes[rule.parent].correction() * rule.map.transpose();
}

/// q_i = sum_j V_j (B_i + B_j) grad W_ij [1/m], with the B of images mirrored. q is zero inside the soil. At a free
/// surface it is the inward normal times a surface delta function. The force of a uniform stress S is S q, so that a
/// traction T acts as -T (n . q) with the outward normal n.
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

/// Particles that the free surface affects: those with a surface vector of sufficient length, and all within a kernel's
/// reach of the first row. Otherwise the third row in 3D, with a surface vector of 0.0199 / spacing, would lose 2 % of
/// the load. surface [1/m]: surface_vectors().
template <int D>
std::vector<char> feel_surface(double spacing, const State<D>& state, const VecArray<D>& surface) {
  const std::size_t n = surface.size();
  const auto length = [&](std::size_t i) { return surface[i].norm() * spacing; };
  std::vector<char> feels(n);
  for (std::size_t i = 0; i < n; ++i) feels[i] = length(i) >= exchange::surface;
  for_each_ordered_pair(state.near.pairs, [&](std::size_t i, std::size_t j, std::size_t) {
    if (length(j < n ? j : state.near.images[j - n].parent) >= exchange::first_row) feels[i] = 1;
  });
  return feels;
}

/// Gradient of the pore pressure at the soil's particles [Pa/m], Eq. (62) with the corrected sign, divided by n_s. It
/// consists of differences p_j - p_i with corrected kernel gradients. Hence it is exact for linear pressure (buoyancy)
/// and independent of the position of the water's surface. Only real particles and periodic images contribute, since
/// the water behind a wall is unknown.
template <int D>
VecArray<D> pressure_gradient_difference(const State<D>& state, std::span<const double> pressure);

/// Sets the gradient of the pore pressure [Pa/m] of the given particles below a loaded face, in the adjoint form of the
/// stress. Stress and pressure then carry the load together, row by row, even if the pressure falls steeply at the
/// face. pressure [Pa]: excess over the pressure beyond the face.
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

/// Gradient of the pore pressure by Eq. (61), sum_j m_j rho_i (p_i/rho_i^2 + p_j/rho_j^2) grad W [Pa/m]. At a free
/// surface of the soil it acts as if the pressure fell to zero there, and expels the particles; it serves for
/// comparison. Images have the hydrostatic mirror pressure p' = p + rho_w g . (x' - x). water_weight: rho_w g [N/m3].
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
