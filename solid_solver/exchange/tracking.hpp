// The motion of the soil that the fluid predicted, and the impedance against departures from this motion in a window.
#pragma once

#include "solid_solver/dynamics/step.hpp"
#include "solid_solver/exchange/water_answer.hpp"
#include "solid_solver/exchange/water_load.hpp"

namespace poretwin::solid {

/// The response of the water to the soil's own motion. Where the soil departs from the velocity that the fluid
/// predicted, drag entrains water while the pressure stays the same. Backward Euler for Eq. (27), with the water's
/// velocity eliminated, gives the impedance Z = C a / (a + C), a = n rho_w / Dt, against the departure at the window's
/// end. Departures grow linearly in a window; a factor on Z makes their mean over the substeps equal to the departure
/// at the end.
///
/// In a long window, which is one step to an equilibrium, the whole drag C opposes a departure, as if the water stood
/// still: the pressure, which would resist soil that yields and dilates, is updated only in the next window. Only the
/// part of this force that is the water's inertia is an impulse of the water. The rest stands for the pressure.
template <int D>
struct Tracking {
  Drive<D> drive;                    ///< includes the tracking coefficients and the target velocity at the window's end
  VecArray<D> start, change;         ///< m/s, velocity of the soil at the window's start, and its change in the window
  ScalarArray goes_along;            ///< per particle: fraction of the impedance that is the water's inertia
  std::vector<WaterAnswer> answers;  ///< only in windows that are repeated; otherwise empty
  double dissipated = 0.0;           ///< J, dissipated by the drag
};

/// The way in which the soil is computed in a window.
struct CrossedAs {
  bool rests = false;     ///< as one step to an equilibrium
  std::size_t steps = 1;  ///< otherwise: number of substeps
};

/// The tracking of a window. found: velocity [m/s] that the last pass through the same window found; used only in later
/// passes of quasi-static windows.
template <int D>
Tracking<D> make_tracking(const Setup<D>& setup, const State<D>& state, const coupling::Window& window,
                          const CrossedAs& crossed, const WaterInput<D>& water, const VecArray<D>& found,
                          PositionCache<D>& cache);

}  // namespace poretwin::solid
