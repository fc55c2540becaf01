// The window's solve for the water as it stands.
#pragma once

#include "fluid_solver/exchange/passes.hpp"
#include "fluid_solver/pressure/window.hpp"
#include "fluid_solver/state.hpp"

namespace poretwin::fluid {

/// What is to be solved in a window of `interval` [s], velocities and sources left out.
template <int D>
WindowProblem<D> window_problem(const Setup<D>& setup, const State<D>& state, double interval);

/// Solves one window; with a quadratic drag repeatedly (Newton), about the relative velocity just found, until the
/// tangent meets the law.
template <int D>
WindowSolution<D> solve_with_drag(const Setup<D>& setup, const Stencil<D>& s, const WindowProblem<D>& in,
                                  const Passes<D>& passes, SoilView<D>& view, State<D>& state);

/// Throws where a solution is not finite.
template <int D>
void check_finite(const State<D>& state, const WindowSolution<D>& solution, double time);

/// Makes a solution the state's, and counts what it took; time [s]: at the window's end.
template <int D>
void take_solution(const WindowSolution<D>& solution, double time, State<D>& state);

}  // namespace poretwin::fluid
