// Walls through which a kernel reaches: thinner than its support, or single lines with water or soil on both sides
// (2D).
#pragma once

#include "common/case/case.hpp"
#include "common/particles/images.hpp"

#include <optional>
#include <string>
#include <vector>

namespace poretwin {

/// Whose particles a wall keeps apart: those of the water, in soil or free, or those of soil that moves.
enum class Keeps { water, soil };

/// A place at which a wall is thin.
struct ThinWall {
  std::size_t wall = 0;
  Point3 at = Point3::Zero();  ///< m
  double thickness = 0.0;      ///< m; of a line 0
  double least = 0.0;          ///< thickness from which on no kernel reaches through it [m]
  bool both_sides = false;     ///< water or soil stands on both sides
};

/// The reason why particles cannot be separated by a line of sight past walls; none where they can. Water: in 2D, in
/// soil at rest or without soil, without inlets, overflowing reservoirs and periodic sides. Soil: in 2D, without pore
/// water that is solved for, plates and periodic sides.
std::optional<std::string> hinders_sight(const Case& scene, Keeps what);

/// Is a line of sight past walls needed, in a scene that allows it? It is where walls are thin, and for water that all
/// seeps through one soil at corners at which a wall turns away from the water and at ends where a water face continues
/// the wall: there the velocity has no bound, and the water balance shows pairs that are counted twice or from one side
/// only.
bool sight_matters(const Case& scene, Keeps what);

/// Does water, in soil or free, or soil stand on both sides of the wall, so that it is a line with two sides?
bool has_two_sides(const Case& scene, const Wall& wall, Keeps what);

/// The walls through which kernels reach: one place for each piece.
std::vector<ThinWall> thin_walls(const Case& scene, Keeps what);

/// Error of coordinates by rounding, in units of the margin.
inline constexpr double sight_slack = 1e-9;

/// The pieces of the walls as mirrors for a Sight, with the wall's number as boundary: a line with two sides has one on
/// each. They end where they are drawn, but at a water face, behind which they go on for `margin` [m].
std::vector<sph::ImagePlane<2>> sides_of_walls(const Case& scene, Keeps what, double margin);

}  // namespace poretwin
