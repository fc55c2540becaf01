// How long the next window may be.
#pragma once

#include "fluid_solver/boundary/columns.hpp"
#include "fluid_solver/state.hpp"

namespace poretwin::fluid {

/// Longest window in which gravity waves of one spacing on a free surface are followed [s].
template <int D>
double wave_interval(const Setup<D>& setup);

/// Speed below which soil and the water in it are as good as at rest: a hundredth of what gravity gives in the window
/// of the shortest waves [m/s].
template <int D>
double quasi_static_speed(const Setup<D>& setup);

/// Longest window that the motion of particle a of free water allows [s].
template <int D>
double free_interval(const Setup<D>& setup, const Particles<D>& p, std::size_t a);

/// Whether a load begins at a time [s], to rounding.
template <int D>
bool load_begins(const Setup<D>& setup, double time);

/// Starts the control of windows by the change of pressure. interval [s]: of the window in which soil answers for the
/// first time, 0 before the first; first_interval [s]: the shortest that control may ask for.
template <int D>
void begin_control(const Setup<D>& setup, const SoilView<D>& view, double interval, State<D>& state,
                   double& first_interval);

/// Next interval from the pressure change of this one; never from a clock.
template <int D>
void control_interval(const Setup<D>& setup, const ScalarArray& before, double interval, double first_interval,
                      State<D>& state);

/// Limits of the next window that follow from this one, which State::window_limits keeps: by_slowing begins them anew.
template <int D>
void limit_by_slowing(const Setup<D>& setup, const VecArray<D>& velocity_before, double interval, State<D>& state);
template <int D>
void limit_by_acceleration(const Setup<D>& setup, const SoilView<D>& view, const VecArray<D>& velocity_before,
                           double interval, State<D>& state);
template <int D>
void limit_scheme(const Setup<D>& setup, const SoilView<D>& view, State<D>& state);

/// The longest next window [s], and what sets it.
template <int D>
std::pair<double, std::string> time_limit(const Setup<D>& setup, const Faces<D>& faces, const State<D>& state,
                                          double first_interval);

}  // namespace poretwin::fluid
