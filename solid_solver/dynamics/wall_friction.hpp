// Walls with Coulomb's friction. Soil that sticks is treated as at a fixed wall: its images have reversed velocities.
// Where soil slips, each particle at the wall has a wall slip s [m/s], and its images have the velocity v' = 2 s - v.
// The wall slip follows from a return map, as for the cone: it is the slip at which the shear stress at the wall is on
// Coulomb's limit.
#pragma once

#include "solid_solver/dynamics/step.hpp"

namespace poretwin::solid {

/// Shear traction [Pa] of the soil on a wall, and the pressure of the soil on it, both extrapolated from the stress of
/// a particle at a distance [m]. The slope of the stress between wall and particle follows from the balance of
/// momentum, d(sigma n)/dn = -(b + w), with the body force b. w = d(sigma t)/dt - rho a (Particles::wall_slope)
/// contains the change of the stress along the wall (direction t) and the inertia of soil that slips with the
/// acceleration a. Without w, waves along the wall grow, and the drag of water in soil that slips throws the soil off.
template <int D>
struct WallShear {
  Vec<D> traction = Vec<D>::Zero();
  double pressure = 0.0;
  /// The fraction of the traction that exceeds the friction that the wall can provide.
  [[nodiscard]] double excess(double friction) const {
    const double size = traction.norm(), most = friction * pressure;
    return size > most ? 1.0 - most / size : 0.0;
  }
};

/// normal: unit, into the soil; body: b + w, N/m3.
template <int D>
WallShear<D> wall_shear(const Tensor& stress, const Vec<D>& normal, double distance, const Vec<D>& body) {
  const Vec<D> at_wall = matrix_of<D>(stress) * normal + distance * body;
  const double across = normal.dot(at_wall);
  return {at_wall - across * normal, std::max(0.0, -across)};
}

/// Factor on the slope of the stress. Soil that has yielded at a wall transmits no more than the wall's reaction, and
/// nothing once it has detached.
template <int D>
double slope_carried(const Particles<D>& p, std::size_t i, const Vec<D>& normal, double distance, const Vec<D>& body) {
  if (p.plastic_strain[i] <= 0.0) return 1.0;
  const double weight = distance * std::abs(normal.dot(body)),
               reaction = -normal.dot(matrix_of<D>(p.stress[i]) * normal);
  return reaction < weight ? std::max(0.0, reaction / weight) : 1.0;
}

/// Applies friction, over a step of dt [s], to slipping soil that artificial viscosity, not stress, keeps off the wall.
/// Otherwise thin sheets and single grains would glide on the wall.
template <int D>
void rub_on_walls(const Setup<D>& setup, double dt, State<D>& state);

/// Updates wall slip, stress and Particles::wall_slope after a step of dt [s] that strained the soil with the previous
/// slip, so that the traction obeys Coulomb's limit. The slip is solved for at particles nearer to a wall than a
/// spacing; those behind take their slip. drive: forces on the soil; null in a search for equilibrium.
template <int D>
void slide_on_walls(const Setup<D>& setup, double dt, const Drive<D>* drive, State<D>& state);

}  // namespace poretwin::solid
