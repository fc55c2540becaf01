// Limits of the next window's length.
#pragma once

#include "fluid_solver/boundary/columns.hpp"
#include "fluid_solver/state.hpp"

namespace poretwin::fluid {

/// Longest window in which gravity waves of one spacing on a free surface are resolved [s].
template <int D>
double wave_interval(const Setup<D>& setup);

/// Speed [m/s] below which soil and the water in it count as at rest: a hundredth of the speed that gravity gives in
/// wave_interval().
template <int D>
double quasi_static_speed(const Setup<D>& setup);

/// Longest window that the motion of particle a of free water allows [s].
template <int D>
double free_interval(const Setup<D>& setup, const Particles<D>& p, std::size_t a);

/// Whether a load begins at a time [s], to rounding.
template <int D>
bool load_begins(const Setup<D>& setup, double time);

/// Starts the control of windows by the change of pressure. interval [s]: length of the window in which the soil first
/// responds; 0 before that window.
template <int D>
void begin_control(const Setup<D>& setup, const SoilView<D>& view, double interval, State<D>& state);

/// Sets the next window that the control allows from this window's change of pressure, independently of the run time.
template <int D>
void control_interval(const Setup<D>& setup, const ScalarArray& before, double interval, State<D>& state);

/// Limits of the next window that follow from this window. They are stored in State::window_limits; limit_by_slowing
/// clears these first.
template <int D>
void limit_by_slowing(const Setup<D>& setup, const VecArray<D>& velocity_before, double interval, State<D>& state);
template <int D>
void limit_by_acceleration(const Setup<D>& setup, const SoilView<D>& view, const VecArray<D>& velocity_before,
                           double interval, State<D>& state);
template <int D>
void limit_scheme(const Setup<D>& setup, const SoilView<D>& view, State<D>& state);

/// The longest next window [s], and the reason for its limit.
template <int D>
std::pair<double, std::string> time_limit(const Setup<D>& setup, const Faces<D>& faces, const State<D>& state);

}  // namespace poretwin::fluid
