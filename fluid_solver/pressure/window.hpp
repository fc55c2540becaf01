// One exchange window: pressure, water velocity and the skeleton's predicted velocity are solved for together. So
// neither the drag nor the skeleton's inertia and stiffness limits the window's length.
#pragma once

#include "fluid_solver/discretisation/bedded_cells.hpp"
#include "fluid_solver/discretisation/free_surface.hpp"
#include "fluid_solver/exchange/soil_view.hpp"

namespace poretwin::fluid {

/// A section through soil at rest that is full of water, through which a gauge needs the discharge (2D).
template <int D>
struct Section {
  Vec<D> from, to;  ///< m, its ends
};

/// Data of one window. Lengths of the arrays: [n] particles, [columns] of the faces.
template <int D>
struct WindowProblem {
  double interval = 0.0;                  ///< s
  double density = 1000.0;                ///< kg/m3, of water
  Vec<D> weight = Vec<D>::Zero();         ///< rho g, N/m3
  Vec<D> origin = Vec<D>::Zero();         ///< piezometric pressure ph = p - rho g.(x - origin)
  bool inertia = true;                    ///< the water has inertia; without inertia drag must act everywhere
  std::optional<Mat<D>> beds;             ///< conductivity of the soil over that along its beds; empty: no beds
  typename BeddedCells<D>::Walls walls;   ///< for soil with beds
  bool response = true;                   ///< the skeleton responds inside the solve
  std::span<const double> void_fraction;  ///< [n]
  std::span<const double> pressure;       ///< [n] Pa, piezometric, at the window's start; empty: the initial guess
  std::span<const Vec<D>> velocity;       ///< [n] m/s, of the water, with viscosity applied; empty: at rest
  OrZero<double> source;                  ///< [n] 1/s, rate of expansion of the volume
  VecArray<D> deferred_flux;            ///< [n] m/s, flux by which the skeleton moved more in earlier windows than was
                                        ///< predicted; empty: none
  std::span<const int> closed_body;     ///< [n] number from 1 of a particle's body of water if only walls surround it,
                                        ///< else 0; empty: all particles form one such body
  double cavitation = -1e300;           ///< Pa, total pressure at which water cavitates
  std::span<const double> void_volume;  ///< [n] m^D, volume of the particle's voids so far; empty: no voids
  std::span<const char> in_seepage;     ///< [n] 0: in soil that moves by itself, or in no soil; empty: nothing moves
  ScalarArray face_pressure;            ///< [columns] Pa, piezometric
  ScalarArray face_slope;               ///< [columns] Pa/m, of the pressure along the inward normal, in the last window
  std::vector<bool> face_holds;         ///< [columns] the face fixes the soil
  std::vector<int> face_soil;           ///< [columns] index in the case of the soil in front, at rest; -1: no soil
  double tolerance = 2e-5;              ///< relative residual of the pressure where no skeleton responds
  std::vector<Section<D>> sections;     ///< sections through which the flow is computed
  std::uint32_t fixed_soil = 0;         ///< boundaries that fix the soil, one bit for each
  int sweeps = 0;                       ///< explicit sweeps in place of the solve; 0: solve
  double interval_over_proposed = 1.0;  ///< length of the window over the length that the fluid proposed: in shorter
                                        ///< windows sweeps do not become stiffer
  void (*between_iterations)() = nullptr;  ///< called while the solve goes on; may throw
};

/// Result of one window; [n], [columns]: as in WindowProblem.
template <int D>
struct WindowSolution {
  ScalarArray pressure;           ///< [n] Pa, piezometric; input: initial guess
  OrZero<Vec<D>> solid_velocity;  ///< [n] m/s, predicted v_s'; input: initial guess
  VecArray<D> velocity;           ///< [n] m/s, v_w'
  VecArray<D> gradient;           ///< [n] Pa/m, of the piezometric pressure
  OrZero<double> void_volume;     ///< [n] m^D, volume of voids in the water
  std::vector<char> at_edge;      ///< [n] 1: soil that the pressure at its edge under free water presses; empty: none
  ScalarArray face_flow;          ///< [columns] m^D/s, flow that the face's pressure drives in; NaN beside a surface
  ScalarArray face_carry;         ///< [columns] m/s, inward discharge per area by inertia, without the face's pressure
  ScalarArray section_flow;       ///< [sections] m^D/s, flow through each section, positive from its right to its left
  int outer = 0, pressure_iterations = 0, multigrid_cycles = 0, skeleton_iterations = 0;
  bool multigrid = false;  ///< input: start with multigrid; output: start the next solve with it
  bool converged = true;
  bool in_doubt = false;  ///< the residual exceeds the tolerance of free water, too
};

/// Solves one window. solution: initial guesses on input, the whole result on output. stencil: of the particles'
/// present positions; soil, flags: at the particles.
template <int D>
void solve_window(const Stencil<D>& stencil, const SoilView<D>& soil, std::span<const Surface> flags,
                  const WindowProblem<D>& problem, WindowSolution<D>& solution);

}  // namespace poretwin::fluid
