// One exchange window: pressure, water velocity and the skeleton's predicted velocity, solved together, so that neither
// the drag nor the skeleton's inertia and stiffness limits the window's length.
#pragma once

#include "fluid_solver/discretisation/free_surface.hpp"
#include "fluid_solver/exchange/soil_view.hpp"

namespace poretwin::fluid {

template <int D>
struct WindowProblem {
  double interval = 0.0;                  ///< s
  double density = 1000.0;                ///< of water, kg/m3
  Vec<D> weight = Vec<D>::Zero();         ///< rho g, N/m3
  Vec<D> origin = Vec<D>::Zero();         ///< piezometric pressure ph = p - rho g.(x - origin)
  bool response = true;                   ///< the skeleton answers inside the solve
  std::span<const double> void_fraction;  ///< [n]
  std::span<const double> pressure;       ///< [n] at the window's start, piezometric, Pa; none: the warm start's
  std::span<const Vec<D>> velocity;       ///< [n] of the water, viscosity already in it, m/s; none: at rest
  OrZero<double> source;                  ///< [n] volume to be given off, 1/s
  std::span<const int> closed_body;  ///< [n] number from 1 of its body if only walls surround that; none: all are one
  double cavitation = -1e300;        ///< total pressure at which water cavitates, Pa
  std::span<const double> void_volume;  ///< [n] volume of its voids so far, m^D; none: no voids
  std::span<const char> in_seepage;     ///< [n] 0: its soil moves by itself or there is none; none: nothing moves
  ScalarArray face_pressure;            ///< [columns] piezometric, Pa
  ScalarArray face_slope;               ///< [columns] of that along the face's normal, into the domain, so far, Pa/m
  std::vector<bool> face_holds;         ///< [columns] the soil
  std::vector<int> face_soil;           ///< [columns] number in the case of the soil before them, at rest; -1: none
  double tolerance = 2e-5;              ///< of the pressure residual, relative, where no skeleton responds
  std::uint32_t fixed_soil = 0;         ///< boundaries that hold the soil, by bits
  int sweeps = 0;                       ///< explicit sweeps in place of the solve; 0: solve
  double interval_over_proposed = 1.0;  ///< window over the phase's own proposal: shorter makes sweeps no stiffer
};

template <int D>
struct WindowSolution {
  ScalarArray pressure;           ///< [n] piezometric, Pa; in: warm start
  OrZero<Vec<D>> solid_velocity;  ///< [n] predicted v_s', m/s; in: warm start
  VecArray<D> velocity;           ///< [n] v_w', m/s
  VecArray<D> gradient;           ///< [n] of the piezometric pressure, Pa/m
  OrZero<double> void_volume;     ///< [n] volume of voids in the water, m^D
  ScalarArray face_flow;          ///< [columns] water that the face's pressure drives in, m^D/s; NaN beside a surface
  ScalarArray face_carry;         ///< [columns] discharge per area that comes in without it, by inertia, m/s
  int outer = 0, pressure_iterations = 0, multigrid_cycles = 0, skeleton_iterations = 0;
  bool multigrid = false;  ///< in: begin with it; out: worth beginning with next time
  bool converged = true;
};

/// Solves one window. In: warm starts; out: everything.
/// stencil: of the particles now; soil, flags: at the particles.
template <int D>
void solve_window(const Stencil<D>& stencil, const SoilView<D>& soil, std::span<const Surface> flags,
                  const WindowProblem<D>& problem, WindowSolution<D>& solution);

}  // namespace poretwin::fluid
