// Decides whether coupled soil moves, so that short windows resolve its waves, or goes from equilibrium to equilibrium
// in long ones; and the length of window that the solid proposes.
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

/// What a rejected window showed of the soil's motion, to be applied when the state at its start is restored.
struct MotionHint {
  bool moves = false;             ///< waves are to be resolved from here on
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

/// Work [J] of the stress on the plastic shear since the accumulated plastic strains were `plastic_before`.
template <int D>
double plastic_work(const Particles<D>& particles, std::span<const double> plastic_before);

/// Stores the plastic shear ratio of a window, times `factor`. plastic_before: accumulated plastic strain at its start.
template <int D>
void store_plastic_shear_ratio(std::span<const double> plastic_before, double interval, double factor, State<D>& state);

/// Whether the kinetic energy is a noticeable part of the energy dissipated meanwhile [J] and exceeds that of creep at
/// the speed `slow` [m/s]. It is that of the velocities' change since `before` [m/s], or of the velocities where
/// `before` is empty.
template <int D>
bool inertia_matters(const Domain& domain, const Particles<D>& particles, std::span<const Vec<D>> before,
                     double dissipated, double slow);

/// Decides, after a window of coupled soil in substeps, whether its motion begins or ends. dissipated: energy
/// dissipated by drag and plastic work [J].
template <int D>
void control_motion(const Setup<D>& setup, const Drive<D>& drive, double interval, double dissipated, State<D>& state);

/// The longest window that the soil accepts now [s], and what limits it.
template <int D>
std::pair<double, std::string> proposed_interval(const Setup<D>& setup, const State<D>& state);

}  // namespace poretwin::solid
