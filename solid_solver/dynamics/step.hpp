// The two-loop symplectic step of the skeleton, and the update of its lists and forces.
#pragma once

#include "solid_solver/setup.hpp"

namespace poretwin::solid {

/// Forces from outside during one substep, besides gravity. Empty arrays stand for zeros.
template <int D>
struct Drive {
  OrZero<Vec<D>> distributed;  ///< N on each particle: the water's pressure and drag
  VecArray<D> traction;        ///< N on each particle near a loaded face
  ScalarArray tracking;        ///< V Z [N s/m] of each particle, in the force V Z (target - v) with which the soil
                               ///< tracks the fluid's prediction: bulk volume V, impedance Z (exchange/tracking.hpp)
  VecArray<D> target;          ///< m/s, target velocity of each particle
  std::vector<PlateOrder<D>> plates;  ///< orders for the plates; empty: the plates do not move
  double damping = 0.0;               ///< 1/s, damping rate of all soil
  bool timeless = false;              ///< velocities serve a search for rest: no strength depends on them
  double damping_of_calm = 0.0;       ///< 1/s, damping rate of regions that are calm while other regions flow
  /// Damping rate [1/s] at a particle.
  [[nodiscard]] double damping_at(const State<D>& state, std::size_t i) const {
    return state.regions.is_calm(i) ? damping_of_calm : damping;
  }
};

/// Evaluates the kernels of all pairs at the present positions.
template <int D>
void evaluate_kernels(const Setup<D>& setup, State<D>& state);

/// Builds lists and images anew. The forces must be evaluated afterwards.
template <int D>
void rebuild_lists(const Setup<D>& setup, State<D>& state);

/// Builds lists and images anew and evaluates the quantities that depend on them: kernels, gradients, corrections.
template <int D>
void rebuild(const Setup<D>& setup, State<D>& state);

/// Rebuilds lists and images when the pair lists no longer hold (lists_hold.hpp); returns whether it did.
template <int D>
bool rebuild_if_moved(const Setup<D>& setup, State<D>& state);

/// Evaluates kernels, internal and stabilising forces of the current state.
template <int D>
void evaluate_forces(const Setup<D>& setup, State<D>& state);

/// Sum of the forces on the free particles from outside the soil [N; 2D: N/m], without those of the water: weight,
/// loads and, by their images, walls.
template <int D>
Vec<D> force_from_outside(const Setup<D>& setup, const State<D>& state, const Drive<D>& drive);

/// One substep of dt [s]. The forces of the state must be current before it, and are current after it. Adds the impulse
/// of the tracking force to state.returned_impulse.
template <int D>
void substep(const Setup<D>& setup, double dt, const Drive<D>& drive, State<D>& state);

/// The kinematic part of a substep, with the present velocities: positions, displacements, volumes and stresses.
template <int D>
void deform(const Setup<D>& setup, double dt, const Drive<D>* drive, State<D>& state);

/// Gradient of the pore pressure [Pa/m] at the soil's particles, by the operator that the case chooses.
template <int D>
VecArray<D> pressure_gradient(const State<D>& state, SolidCase::PressureGradient form, const Vec<D>& water_weight,
                              std::span<const double> pressure);

/// Sets the scale of every load on a line so that the load's total force is traction times length. The scale is
/// measured on the initial lattice, where curved and inclined surfaces have steps and a line may end between two
/// columns of particles.
template <int D>
void measure_loads(const State<D>& state, Setup<D>& setup);

/// Force on each particle [N] of all loads that have begun at `time` [s]. A traction T acts as
/// V (n . q) T with the face's inward normal n and the surface vector q (surface_vectors), of a pressure P on all sides
/// V q P.
template <int D>
VecArray<D> load_forces(const Setup<D>& setup, const State<D>& state, double time);

/// Throws DivergedError, with particle, stress and the last good time, when a value is not finite, when a particle
/// crosses more than a spacing in a substep, or when a plate has sunk too far into soil beside its ends.
template <int D>
void check_sound(const Setup<D>& setup, const State<D>& state, double last_good_time);

}  // namespace poretwin::solid
