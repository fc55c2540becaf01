// Decides whether coupled soil moves, so that its waves are resolved in short windows, or is computed from equilibrium
// to equilibrium in long windows. Also gives the length of window that the solid proposes.
#pragma once

#include "common/coupling/exchange.hpp"
#include "solid_solver/dynamics/step.hpp"

#include <optional>
#include <span>
#include <string>
#include <utility>

namespace poretwin::solid {

/// Longest window in which substeps resolve the waves in the soil [s].
template <int D>
double followed_window(const Setup<D>& setup) {
  return (1.0 + 1e-9) * steps::substeps_while_moving * setup.longest_substep;
}

/// What a rejected window showed of the soil's motion. Applied when the state at the window's start is restored.
struct MotionHint {
  bool moves = false;             ///< waves must be resolved from this window on
  std::optional<double> longest;  ///< s, longest window in which an equilibrium may be searched for
  /// Combines this hint with a later one.
  void add(const MotionHint& other) {
    moves = moves || other.moves;
    if (other.longest) longest = other.longest;
  }
  void apply(double long_window, Motion& motion) const {
    if (longest) motion.longest = *longest;
    if (moves) motion.begins(long_window);
  }
};

/// Work [J] of the stress on the plastic shear since the accumulated plastic strains had the values `plastic_before`.
template <int D>
double plastic_work(const Particles<D>& particles, std::span<const double> plastic_before);

/// Stores the plastic shear ratio of a window, times `factor`. plastic_before: plastic strain at the window's start.
template <int D>
void store_plastic_shear_ratio(std::span<const double> plastic_before, double interval, double factor, State<D>& state);

/// Whether the kinetic energy is a noticeable part of the energy dissipated in the same time [J] and exceeds that of
/// creep at the speed `slow` [m/s]. The kinetic energy is that of the velocities' change since `before` [m/s], or, if
/// `before` is empty, of the velocities.
template <int D>
bool inertia_matters(const Domain& domain, const Particles<D>& particles, std::span<const Vec<D>> before,
                     double dissipated, double slow);

/// Decides, after a window of coupled soil in substeps, whether the soil's motion begins or ends. dissipated: energy
/// dissipated by drag and plastic work [J].
template <int D>
void control_motion(const Setup<D>& setup, const Drive<D>& drive, double interval, double dissipated, State<D>& state);

/// The longest window that the soil accepts at present [s], and the reason for this limit.
template <int D>
std::pair<double, std::string> proposed_interval(const Setup<D>& setup, const State<D>& state);

}  // namespace poretwin::solid
