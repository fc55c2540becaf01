// How far a particle's own pressure drives it.
#pragma once

#include "fluid_solver/discretisation/operators.hpp"
#include "fluid_solver/numerics/motion.hpp"
#include "fluid_solver/numerics/pressure.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin::fluid {

/// In uneven surroundings, sum_b V_b B grad W_ab != 0, the gradient at a particle contains its own pressure. A pressure
/// that is to drive the neighbours apart then drives the particle towards the side where it has few neighbours, and
/// this motion enters its divergence with the opposite sign. The neighbours' response is in proportion to the
/// particle's volume, its own is not: a light particle among heavy ones, such as pore water that leaves coarse soil,
/// would leave every solve with a larger divergence than before, and accelerate without end.
///
/// The response of the particle's divergence to its own pressure, over the mobility, is N - S.S with
///
///   S = sum_b V_b B grad W_ab,    N = sum_b V_a V_b |B grad W_ab|^2 (of the neighbours)
///
/// Where S.S exceeds a share of N (pressure::own_response) only the fraction share N/(S.S) of the difference between
/// its own pressure and the linear field of its neighbours' pressures counts in its own gradient. Linear fields are
/// exact as before. Particles at the free surface and beside water faces are left out: there the pressure beyond is
/// given. (docs/theory/water.md; Test: Operators.ALightParticleDoesNotDriveItself.)
///
/// Calls take(a, excess) with the pressure [Pa] by which the particle's own one is lowered. All ranks call this.
template <int D, class Take>
void limit_own_pressure(const Stencil<D>& s, std::span<const double> own, const Take& take) {
  const auto pressure = s.with_copies(own);
  parallel_for(own.size(), [&](std::size_t a) {
    // In even surroundings S.S is far below N.
    if (s.ghost_distance[a] > 0.0 || s.length(a) * s.normal[a].norm() <= motion::even_surroundings) return;
    Vec<D> S = Vec<D>::Zero();
    double N = 0.0;
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
      const Index j = s.other[k], q = s.parent[j];
      if (q >= s.n_particles) return;
      const Vec<D> w = s.correction[a] * (static_cast<double>(s.gradient_factor[k]) * (s.position[j] - s.position[a]));
      S += w;
      N += s.volume[a] / s.volume[q] * w.squaredNorm();
    }
    const double counts = pressure::own_response * N / S.squaredNorm();
    if (!(counts < 1.0)) return;
    // The linear field of the neighbours' pressures, by least squares with the weights of the gradient.
    double all = 0.0, mean = 0.0;
    Vec<D> centre = Vec<D>::Zero();
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
      const double f = std::abs(static_cast<double>(s.gradient_factor[k]));
      all += f;
      mean += f * pressure[s.parent[s.other[k]]];
      centre += f * (s.position[s.other[k]] - s.position[a]);
    }
    mean /= all;
    centre /= all;
    Mat<D> moment = Mat<D>::Zero();
    Vec<D> right = Vec<D>::Zero();
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
      const double f = std::abs(static_cast<double>(s.gradient_factor[k]));
      const Vec<D> x = s.position[s.other[k]] - s.position[a] - centre;
      moment += f * x * x.transpose();
      right += f * (pressure[s.parent[s.other[k]]] - mean) * x;
    }
    const double determinant = moment.determinant(), size = moment.trace() / D;
    if (!(determinant > 1e-6 * std::pow(size, D))) return;  // its neighbours lie on a line
    const double linear = mean - centre.dot(moment.inverse() * right);
    take(a, (1.0 - counts) * (own[a] - linear));
  });
}

}  // namespace poretwin::fluid
