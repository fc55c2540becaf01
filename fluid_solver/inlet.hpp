// Openings through which real water comes and goes: pistons. A mirror moves in with the water; when it has pushed by a
// spacing it steps back, and a row of particles stands where it stood (after Lastiwka et al. 2009, whose inflow zone
// the mirror's images are). What is let in is exact: the piston's way times its width.
#pragma once

#include "common/case/case.hpp"
#include "common/core/vector.hpp"
#include "common/sph/images.hpp"

#include <cmath>
#include <vector>

namespace poretwin::fluid {

template <int D>
struct Inlet {
  int face = 0;                                              ///< of Case::water_faces
  Vec<D> foot = Vec<D>::Zero();                              ///< middle of the opening [m]
  Vec<D> normal = Vec<D>::Zero(), tangent = Vec<D>::Zero();  ///< unit; normal into the domain
  double width = 0.0;                                        ///< m
  double lowest = 0.0, highest = 0.0;                        ///< elevations of its ends [m]
  double spacing = 0.0;                                      ///< of the rows along the normal [m]
  int row = 0;                                               ///< particles in a row
  double piston = 0.0;                                       ///< how far it stands inside [m]
  double speed = 0.0;                                        ///< inwards [m/s]
  double level = 0.0;                                        ///< of the water before it [m]
  double net = 0.0;                                          ///< volume of particles born less taken away [m^D]
  [[nodiscard]] double depth(const Vec<D>& x) const { return normal.dot(x - foot) - piston; }
  [[nodiscard]] bool before(const Vec<D>& x) const { return 2.0 * std::abs(tangent.dot(x - foot)) <= width; }
  /// Volume of water that has come in, less what has gone out [m^D].
  [[nodiscard]] double passed() const { return net + piston * width; }
};

template <int D>
std::vector<Inlet<D>> make_inlets(const Case& scene);

/// Speed inwards through one window [m/s]: of the discharge prescribed, or of what brings the water before the opening
/// to the level prescribed, Q = sqrt(g d) (H - level), the discharge of a long wave of that height in water d deep: it
/// neither sends a wave that comes in back nor needs the area of the reservoir.
template <int D>
double inlet_speed(const Case& scene, const Inlet<D>& inlet, double time, double interval);

/// The walls, pistons and periodic sides of the water as mirrors. Pieces that end where no other begins, or in a corner
/// of less than 180 degrees, go on for `margin` [m], to fill the corner.
template <int D>
std::vector<sph::ImagePlane<D>> water_planes(const Case& scene, const std::vector<Inlet<D>>& inlets, double margin);

/// Number of the boundary for the pistons and for periodic sides.
inline constexpr int piston_boundary = 30, periodic_boundary = 31;

}  // namespace poretwin::fluid
