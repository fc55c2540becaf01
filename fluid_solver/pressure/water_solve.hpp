// The pressure solve of one window for the water in its present state.
#pragma once

#include "fluid_solver/boundary/walls.hpp"
#include "fluid_solver/exchange/passes.hpp"
#include "fluid_solver/pressure/window.hpp"
#include "fluid_solver/state.hpp"

namespace poretwin::fluid {

/// The problem of a window of `interval` [s], without velocities and sources.
template <int D>
WindowProblem<D> window_problem(const Setup<D>& setup, const Walls<D>& walls, const State<D>& state, double interval);

/// The sections of the gauges of kind discharge, in their order, where the pressure drives the whole flow: in 2D, in
/// soil at rest that is full of water. Elsewhere the result is empty.
template <int D>
std::vector<Section<D>> solved_sections(const Setup<D>& setup, const State<D>& state);

/// Solves one window. With a quadratic drag the window is solved again for the relative velocity just found (Newton's
/// iteration) until the tangent agrees with the law.
template <int D>
WindowSolution<D> solve_with_drag(const Setup<D>& setup, const Stencil<D>& s, const WindowProblem<D>& in,
                                  const Passes<D>& passes, SoilView<D>& view, State<D>& state);

/// Throws DivergedError where a solution is not finite. time [s]: of the last state that was finite.
template <int D>
void check_finite(const State<D>& state, const WindowSolution<D>& solution, double time);

/// Copies a solution into the state and updates the counters. time [s]: at the window's end.
template <int D>
void take_solution(const Setup<D>& setup, const WindowSolution<D>& solution, double time, State<D>& state);

}  // namespace poretwin::fluid
