// The two-loop symplectic step of the skeleton, and the update of its lists and forces.
#pragma once

#include "solid_solver/setup.hpp"

namespace poretwin::solid {

/// Forces from outside during one substep, besides gravity; empty arrays mean none.
template <int D>
struct Drive {
  OrZero<Vec<D>> distributed;    ///< N on each particle: the water's pressure and seepage
  VecArray<D> traction;          ///< N on each particle near a loaded face
  ScalarArray tracking;          ///< V Z [N s/m], of the force V Z (target - v)
  VecArray<D> target;            ///< m/s
  double damping = 0.0;          ///< 1/s, only while the initial rest is sought
  double damping_of_calm = 0.0;  ///< 1/s, of regions that are calm while others move
};

/// Builds lists and images anew; forces are to be evaluated then.
template <int D>
void rebuild_lists(const Setup<D>& setup, State<D>& state);

/// Builds lists and images anew and evaluates all that depends on them.
template <int D>
void rebuild(const Setup<D>& setup, State<D>& state);

/// Rebuilds lists and images when the pair lists no longer hold (lists_hold.hpp); returns whether it did.
template <int D>
bool rebuild_if_moved(const Setup<D>& setup, State<D>& state);

/// Kernels, internal and stabilising forces of the current state.
template <int D>
void evaluate_forces(const Setup<D>& setup, State<D>& state);

/// Sum of what acts on the free particles from outside the soil [N, 2D: N/m]: weight, loads, and through their images
/// the walls. Not the water.
template <int D>
Vec<D> force_from_outside(const Setup<D>& setup, const State<D>& state, const Drive<D>& drive);

/// One substep of dt [s]. The forces of the state must be current, and are so again afterwards. The impulse of tracking
/// is added to state.returned_impulse.
template <int D>
void substep(const Setup<D>& setup, double dt, const Drive<D>& drive, State<D>& state);

/// The kinematic part of a substep, at the present velocities: positions, volumes and stresses.
template <int D>
void deform(const Setup<D>& setup, double dt, const Drive<D>* drive, State<D>& state);

/// Pore-pressure gradient [Pa/m] at the soil's points, by the operator the case chose.
template <int D>
VecArray<D> pressure_gradient(const State<D>& state, SolidCase::PressureGradient form, const Vec<D>& water_weight,
                              std::span<const double> pressure);

/// Sets the scale of every load on a line so that its force is traction times length of the line, on the initial
/// lattice: there a curved or inclined surface has steps, and a line need not end between two columns.
template <int D>
void measure_loads(const State<D>& state, Setup<D>& setup);

/// Force of all loads that have begun at `time` [N per particle]: a traction acts as the force of unit stress does.
template <int D>
VecArray<D> load_forces(const Setup<D>& setup, const State<D>& state, double time);

/// Throws DivergedError naming particle, stress and the last good time when anything is not finite, or crosses more
/// than a spacing in a substep.
template <int D>
void check_sound(const Setup<D>& setup, const State<D>& state, double last_good_time);

}  // namespace poretwin::solid
