// Whether coupled soil moves, so that its waves are followed in short windows, or is led from equilibrium to
// equilibrium in long ones; and the interval that it proposes.
#pragma once

#include "common/coupling/exchange.hpp"
#include "solid_solver/dynamics/step.hpp"

#include <optional>
#include <span>
#include <string>
#include <utility>

namespace poretwin::solid {

/// Windows up to this follow the waves in the soil [s].
template <int D>
double followed_window(const Setup<D>& setup) {
  return (1.0 + 1e-9) * steps::substeps_while_moving * setup.longest_substep;
}

/// What a rejected window taught of the soil's motion, for when its start is restored.
struct MotionHint {
  bool moves = false;             ///< waves are to be followed from here on
  std::optional<double> longest;  ///< s, window in which an equilibrium may be looked for
  /// What both say, the other being the later.
  void add(const MotionHint& other) {
    moves = moves || other.moves;
    if (other.longest) longest = other.longest;
  }
  void apply(double long_window, Motion& motion) const {
    if (longest) motion.longest = *longest;
    if (moves) motion.begins(long_window);
  }
};

/// Work of the stress on the plastic shear since `plastic_before` [J].
template <int D>
double plastic_work(const Particles<D>& particles, std::span<const double> plastic_before);

/// Stores the plastic shear ratio of a window, times `factor`; `plastic_before`: plastic strain at its start.
template <int D>
void store_plastic_shear_ratio(std::span<const double> plastic_before, double interval, double factor, State<D>& state);

/// Whether the soil's motion, or what it changed by since `before` (none: all of it) [m/s], holds a noticeable part
/// of the energy dissipated meanwhile [J], and more than creep at a speed [m/s] would.
template <int D>
bool inertia_matters(const Particles<D>& particles, std::span<const Vec<D>> before, double dissipated, double slow);

/// After a window of coupled soil in substeps: whether its motion begins or is over. dissipated: by the drag and by
/// plastic work [J].
template <int D>
void control_motion(const Setup<D>& setup, const Drive<D>& drive, double interval, double dissipated, State<D>& state);

/// The longest window that the soil takes now [s], and what sets it.
template <int D>
std::pair<double, std::string> proposed_interval(const Setup<D>& setup, const State<D>& state);

}  // namespace poretwin::solid
