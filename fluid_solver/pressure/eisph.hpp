// Explicit incompressible SPH (Nomeritae et al. 2016; Eqs. (82)-(85)). In place of a solve of the pressure equation,
// one or a few sweeps per window start from the pressure of the last window.
#pragma once

#include "common/numerics/csr.hpp"
#include "fluid_solver/discretisation/stencil.hpp"
#include "fluid_solver/numerics/pressure.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin::fluid {

/// Eq. (85), relaxed, for all particles: p_a <- p_a + omega_a (B_a + sum A_ab p_b - p_a sum A_ab) / sum A_ab. B
/// contains the divergence of the predicted velocity, which is Eq. (84) with the density reset after each window.
inline void relaxed_sweeps(const PairMatrix& A, std::span<const double> b, std::span<const double> relaxation,
                           std::span<double> p, int sweeps) {
  ScalarArray row(p.size());
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    A.apply(std::span<const double>(p), std::span<double>(row));
    for (std::size_t a = 0; a < p.size(); ++a)
      if (A.diagonal[a] > 0.0) p[a] += relaxation[a] * (b[a] - row[a]) / A.diagonal[a];
  }
}

/// Fraction of its velocity's divergence to which particle a responds by its pressure.
///
/// Inside water, a pressure p above that of the neighbours acts in two ways. Through its gradient, formed of
/// differences, it moves the particle towards its neighbours, by |L n|^2 p with the correction L and n = sum V grad W.
/// It pushes the neighbours away, by sum V_a V_b (L_a grad W).(L_b grad W) p. Where the first effect is larger, the
/// pressure increases its own cause, by up to a fifth per window of any length. Then the particle takes its neighbours'
/// pressure. A solve has the same term, in a tenth as many windows.
template <int D>
double sweep_trust(const Stencil<D>& s, std::size_t a) {
  if (s.ghost_distance[a] > 0.0) return 1.0;
  const double own = (s.correction[a] * s.normal[a]).squaredNorm();
  double others = 0.0;
  for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
    const Index j = s.other[k], b = s.parent[j];
    if (b >= s.n_real) continue;
    const Vec<D> w = static_cast<double>(s.gradient_factor[k]) * (s.position[j] - s.position[a]);
    Vec<D> theirs = s.correction[b] * w;
    if (j >= s.n_base) {
      const auto& map = s.map[j - s.n_base];
      theirs = map * (s.correction[b] * (map.transpose() * w));
    }
    others += s.volume[a] / s.volume[b] * (s.correction[a] * w).dot(theirs);
  }
  return others > 0.0 ? std::clamp(2.0 * (1.0 - own / others), 0.0, 1.0) : 0.0;
}

/// Sum of 2 V G over a lattice of unit spacing, G = -W'/r: the diagonal of the Laplacian on the lattice, in units of
/// 1/spacing^2.
template <int D>
double lattice_diagonal() {
  static const double value = lattice_sum<D>(
      [](double r) { return r > 0.0 ? -2.0 * Kernel<D>::derivative_over_r(r, points::smoothing_ratio) : 0.0; });
  return value;
}

/// Longest window [s] for sweeps. In one sweep, water of mobility kf = n^2/(n rho/dt + C) responds to a divergence like
/// a compressible fluid, by a fraction dt kf diagonal/omega of its volume per pressure. In free water this fraction
/// increases with dt^2 (an artificial sound of about one spacing per window), in soil with dt (pressure diffuses one
/// spacing per window). n: void fraction; drag: C [N s/m4]; pressure: largest pressure that may drive the flow or be
/// relieved [Pa]; spacing: of the particles [m].
template <int D>
double sweep_interval(double n, double drag, double density, double pressure, double spacing, int sweeps) {
  const double quadratic =
      n * pressure * lattice_diagonal<D>() / (spacing * spacing * pressure::sweep_relaxation * sweeps);
  const double linear = pressure::soil_compression * drag, constant = pressure::free_compression * n * density;
  if (!(quadratic > 0.0)) return HUGE_VAL;
  return (linear + std::sqrt(linear * linear + 4.0 * quadratic * constant)) / (2.0 * quadratic);
}

/// Relaxation factor in a window that is this fraction of the interval that the fluid proposed. It is reduced so that
/// the apparent stiffness of the water stays the same. Otherwise a window of a hundredth of that interval would respond
/// to the last window's residual by a pressure ten thousand times as large, which would remain in later long windows.
/// inertia: n rho/dt; drag: C [N s/m4].
inline double relaxation_in(double fraction, double inertia, double drag) {
  if (fraction >= 1.0) return pressure::sweep_relaxation;
  return pressure::sweep_relaxation * fraction * (inertia * fraction + drag) / (inertia + drag);
}

}  // namespace poretwin::fluid
