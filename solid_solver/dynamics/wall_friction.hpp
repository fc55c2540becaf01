// Walls with Coulomb's friction. Soil that sticks to one is soil at a fixed wall: images with reversed velocities. Soil
// that slips keeps a slip velocity s of its own for each particle that touches the wall, and its images are reversed
// about it, v' = 2 s - v. The slip is whatever brings the shear stress at the wall back to Coulomb's limit: a return
// map, as for the cone.
#pragma once

#include "solid_solver/setup.hpp"

namespace poretwin::solid {

/// Shear traction [Pa] of the soil on a wall and the pressure that it is held against, from the stress of a particle at
/// a distance [m]: between them the stress on planes along the wall has the slope of the body force, d(sigma n)/dn =
/// -b.
template <int D>
struct WallShear {
  Vec<D> traction = Vec<D>::Zero();
  double pressure = 0.0;
  /// Share of the traction that is more than the friction can bear.
  [[nodiscard]] double excess(double friction) const {
    const double size = traction.norm(), most = friction * pressure;
    return size > most ? 1.0 - most / size : 0.0;
  }
};

/// normal: unit, into the soil; body: N/m3.
template <int D>
WallShear<D> wall_shear(const Tensor& stress, const Vec<D>& normal, double distance, const Vec<D>& body) {
  const Vec<D> at_wall = matrix_of<D>(stress) * normal + distance * body;
  const double across = normal.dot(at_wall);
  return {at_wall - across * normal, std::max(0.0, -across)};
}

/// Share of that slope that is there. Soil that has yielded at a wall has no more than the wall's reaction to it: none
/// once it has come loose.
template <int D>
double slope_carried(const Particles<D>& p, std::size_t i, const Vec<D>& normal, double distance, const Vec<D>& body) {
  if (p.plastic_strain[i] <= 0.0) return 1.0;
  const double weight = distance * std::abs(normal.dot(body)),
               reaction = -normal.dot(matrix_of<D>(p.stress[i]) * normal);
  return reaction < weight ? std::max(0.0, reaction / weight) : 1.0;
}

/// Friction, over a step of dt [s], of what slips and is held off the wall by viscosity instead of stress: thin sheets
/// and single grains would else glide on it.
template <int D>
void rub_on_walls(const Setup<D>& setup, double dt, State<D>& state);

/// After a step of dt [s] has strained the soil with the slip it had: the slip that Coulomb's limit asks for, and the
/// stress with it. It is found for particles nearer to a wall than a spacing; those behind follow them.
template <int D>
void slide_on_walls(const Setup<D>& setup, double dt, State<D>& state);

}  // namespace poretwin::solid
