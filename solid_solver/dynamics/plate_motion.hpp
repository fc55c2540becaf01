// The motion of rigid plates, and the force of the soil on them (docs/theory/plates.md).
#pragma once

#include "solid_solver/discretisation/turning.hpp"
#include "solid_solver/dynamics/step.hpp"

namespace poretwin::solid {

/// Sets the velocities of the plates for a step of dt [s]. They bring plates to their targets; for plates under a
/// force, they follow from the force and the soil's reaction, with the damping rate of the soil.
template <int D>
void drive_plates(const Setup<D>& setup, double dt, const Drive<D>& drive, State<D>& state);

/// Sums the forces of the skeleton and of the pore water on each plate [N], in the present state. The skeleton's force
/// is minus the sum of the forces that the images behind the plate exert on the soil's particles, stabilising forces
/// included. The water's force is that of a stress equal to the pore pressure at the plate, p - d n . grad p, with the
/// particle's distance d from the plate and the plate's normal n: the effective stress is extrapolated to the plate in
/// the same way. In 3D only the part along the normal is complete: where a rough plate ends on a wall, images behind
/// both also shear the soil along their edge, and this force is counted for neither. The forces of the state must be
/// current.
///
/// Of plates that tilt it also sums the moments [N m/m] about their middles. The moment of the skeleton is minus the
/// rate at which the soil gains angular momentum from the images: that of the forces f of the images at their
/// particles, and, since the stress of a particle i is symmetric only in the sum over all its neighbours j, that of V_i
/// V_j sigma_i B_i grad W_ij with the arm x_j - x_i.
template <int D>
void measure_reactions(const Setup<D>& setup, State<D>& state);

/// Counts, at the end of a window, the plates that pull at the soil and do not come off. A plate that tilts also pulls
/// where a part of it does.
template <int D>
void count_pulls(const Setup<D>& setup, State<D>& state);

/// Lets parts of plates that lift come off where they pull at the soil, and touch again where the gap has closed.
/// Returns whether any did; the lists no longer hold then. The reactions of the state must be current.
template <int D>
bool update_contacts(const Setup<D>& setup, State<D>& state);

/// Force [N] with which plate k presses on the soil, along its normal.
template <int D>
double pressing(const Setup<D>& setup, const State<D>& state, std::size_t k) {
  const PlateMotion<D>& motion = state.particles.plates[k];
  return std::cos(motion.angle) * motion.water - setup.plates[k].normal.dot(motion.reaction);
}

/// Force [N] along its normal that plate k lacks for balance; 0 where its motion is prescribed.
template <int D>
double unbalanced(const Setup<D>& setup, const State<D>& state, const Drive<D>& drive, std::size_t k) {
  if (!setup.plates[k].is_free() || drive.plates.empty()) return 0.0;
  const PlateMotion<D>& motion = state.particles.plates[k];
  return drive.plates[k].force + setup.plates[k].normal.dot(motion.reaction) - std::cos(motion.angle) * motion.water;
}

/// Moment [N m/m] about its middle, counter-clockwise, that plate k lacks for balance; 0 where it does not tilt.
template <int D>
double unbalanced_moment(const Setup<D>& setup, const State<D>& state, const Drive<D>& drive, std::size_t k) {
  const PlateSetup<D>& plate = setup.plates[k];
  if (!plate.tilts || drive.plates.empty()) return 0.0;
  const PlateMotion<D>& motion = state.particles.plates[k];
  const double arm = plate.eccentricity * std::cos(motion.angle);
  return drive.plates[k].moment + arm * drive.plates[k].force + motion.moment - motion.water_moment;
}

/// The same for one freedom: a force [N], or the force at the plate's end that has the moment.
template <int D>
double unbalanced(const Setup<D>& setup, const State<D>& state, const Drive<D>& drive, const PlateFreedom& freedom) {
  return freedom.turns ? unbalanced_moment(setup, state, drive, freedom.plate) / setup.plates[freedom.plate].half
                       : unbalanced(setup, state, drive, freedom.plate);
}

/// Acceleration [m/s2] that the unbalanced force, or moment at its ends, would give plate k if it were as heavy as a
/// row of the soil before it.
template <int D>
double acceleration_of_plate(const Setup<D>& setup, const State<D>& state, const Drive<D>& drive, std::size_t k) {
  const PlateSetup<D>& plate = setup.plates[k];
  const double pushed = std::abs(unbalanced(setup, state, drive, k)) / plate.row;
  if (!plate.tilts) return pushed;
  return std::max(pushed, std::abs(unbalanced_moment(setup, state, drive, k)) * plate.half / plate.row_inertia);
}

/// Whether a plate has to move in a step, or its forces are out of balance by more than `share` of the reference
/// acceleration `reference` [m/s2].
template <int D>
bool plates_move(const Setup<D>& setup, const State<D>& state, const Drive<D>& drive, double share, double reference) {
  for (std::size_t k = 0; k < drive.plates.size(); ++k) {
    Vec<D> way = drive.plates[k].target - state.particles.plates[k].displacement;
    if (setup.plates[k].is_free()) way -= setup.plates[k].normal.dot(way) * setup.plates[k].normal;
    if (!way.isZero(0.0)) return true;
    if (acceleration_of_plate(setup, state, drive, k) > share * reference) return true;
  }
  return false;
}

/// Largest acceleration_of_plate() [m/s2].
template <int D>
double acceleration_of_plates(const Setup<D>& setup, const State<D>& state, const Drive<D>& drive) {
  double largest = 0.0;
  for (std::size_t k = 0; k < setup.plates.size(); ++k)
    largest = std::max(largest, acceleration_of_plate(setup, state, drive, k));
  return largest;
}

}  // namespace poretwin::solid
