// The soil's motion as the fluid predicted it, and the impedance against departures from it in a window.
#pragma once

#include "solid_solver/dynamics/step.hpp"
#include "solid_solver/exchange/water_answer.hpp"
#include "solid_solver/exchange/water_load.hpp"

namespace poretwin::solid {

/// The water answers to the soil's own motion: where the soil departs from the velocity that the fluid predicted,
/// the drag takes the water along while the pressure stays. Backward Euler of (27), the water eliminated, leaves the
/// impedance Z = C a / (a + C), a = n rho_w / Dt, against the departure at the window's end. In the window departures
/// grow linearly; a factor on Z makes their mean over the substeps the one at the end.
/// In a long window, one step to an equilibrium, what departs meets the drag, C, as if the water stood still: the
/// pressure, which would answer to soil that yields and dilates, does not know of it before the next window. Of that
/// force only the part that is the water's inertia is an impulse of the water; the rest stands for the pressure.
template <int D>
struct Tracking {
  Drive<D> drive;                    ///< its tracking coefficients, and its target at the window's end
  VecArray<D> start, change;         ///< m/s, velocity of the soil at the window's start, and its change in the window
  ScalarArray goes_along;            ///< share of the impedance that is the water's inertia
  std::vector<WaterAnswer> answers;  ///< of windows that are repeated; else empty
  double dissipated = 0.0;           ///< J, by the drag
};

/// How a window is crossed.
struct CrossedAs {
  bool rests = false;     ///< as one step to an equilibrium
  std::size_t steps = 1;  ///< else in so many substeps
};

/// found: m/s, velocity that the last pass through the same window found; read in its later passes, and only of soil
/// that rests.
template <int D>
Tracking<D> make_tracking(const Setup<D>& setup, const State<D>& state, const coupling::Window& window,
                          const CrossedAs& crossed, const WaterInput<D>& water, const VecArray<D>& found,
                          PositionCache<D>& cache);

}  // namespace poretwin::solid
