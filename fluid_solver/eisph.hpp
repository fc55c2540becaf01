// Explicit incompressible SPH (Nomeritae et al. 2016; Eqs. (82)-(85)): the pressure equation is not solved but swept
// over, once or a few times per window, from the pressure of the window before.
#pragma once

#include "fluid_solver/csr.hpp"
#include "fluid_solver/stencil.hpp"

#include <cmath>

namespace poretwin::fluid {

/// Relaxation of a sweep. The largest eigenvalue of a graph Laplacian over its diagonal is 2 at worst (two particles
/// alone with each other), where an unrelaxed sweep is at the limit of its stability; 1.2 on a lattice.
inline constexpr double sweep_relaxation = 0.8;

/// Share of its volume by which free water may seem compressed at the pressures at hand: 1 %, as in weakly compressible
/// SPH (Monaghan 1994: a speed of sound ten times the flow's). In a dam break 3 % costs the front 2 cm of 1.9 m.
inline constexpr double free_compression = 0.01;
/// The same in soil, where it only delays: 10 % shifts a wetting front by 0.15 %.
inline constexpr double soil_compression = 0.1;

/// Eq. (85), relaxed: p_a <- p_a + omega (B_a + sum A_ab p_b - p_a sum A_ab) / sum A_ab, all particles at once.
/// B holds the divergence of the predicted velocity: that is Eq. (84) with the density reset after each window.
inline void relaxed_sweeps(const PairMatrix& A, std::span<const double> b, std::span<double> p, int sweeps) {
  ScalarArray row(p.size());
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    A.apply(std::span<const double>(p), std::span<double>(row));
    for (std::size_t a = 0; a < p.size(); ++a)
      if (A.diagonal[a] > 0.0) p[a] += sweep_relaxation * (b[a] - row[a]) / A.diagonal[a];
  }
}

/// Sum of 2 V G over a lattice of unit spacing: the Laplacian's diagonal there, in units of 1/spacing^2.
template <int D>
double lattice_diagonal() {
  static const double value =
      lattice_sum<D>([](double r) { return r > 0.0 ? -2.0 * Kernel<D>::derivative_over_r(r, smoothing_ratio) : 0.0; });
  return value;
}

/// Longest window [s] of the sweep. Swept once, water of mobility kf = n^2/(n rho/dt + C) answers to a divergence like
/// a compressible fluid, by dt kf diagonal/omega of its volume per pressure: in free water that grows with dt^2 (an
/// artificial sound of about one spacing per window), in soil with dt (pressure diffuses one spacing per window).
/// n: void fraction; drag: C [N s/m4]; pressure: that drives or may be relieved [Pa]; spacing: of the particles [m].
template <int D>
double sweep_interval(double n, double drag, double density, double pressure, double spacing, int sweeps) {
  const double quadratic = n * pressure * lattice_diagonal<D>() / (spacing * spacing * sweep_relaxation * sweeps);
  const double linear = soil_compression * drag, constant = free_compression * n * density;
  if (!(quadratic > 0.0)) return HUGE_VAL;
  return (linear + std::sqrt(linear * linear + 4.0 * quadratic * constant)) / (2.0 * quadratic);
}

}  // namespace poretwin::fluid
