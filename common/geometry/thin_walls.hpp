// Walls through which a kernel reaches: thinner than that, or single lines with water on both sides (2D).
#pragma once

#include "common/case/case.hpp"
#include "common/particles/images.hpp"

#include <optional>
#include <string>
#include <vector>

namespace poretwin {

/// A place at which a wall is thin.
struct ThinWall {
  std::size_t wall = 0;
  Point3 at = Point3::Zero();  ///< m
  double thickness = 0.0;      ///< m; of a line 0
  double least = 0.0;          ///< from which on nothing is felt through it [m]
  bool both_sides = false;     ///< water, in soil or free, stands on both sides
};

/// What keeps water from seeing past walls by a line of sight alone; nothing where it can: water in the plane, in soil
/// at rest or in none, without inlets and without periodic sides.
std::optional<std::string> hinders_sight(const Case& scene);

/// Does what a kernel reaches through, or past a corner, matter to the water of a scene that nothing hinders? Walls
/// that are thin; and where all water seeps through one soil, corners at which a wall turns away from it, and ends at
/// which it goes on as a water face: there a flow has no bound, and its balance shows what is seen twice or by one side
/// only.
bool sight_matters(const Case& scene);

/// Does water, in soil or free, stand on both sides of the wall, so that it is a line that holds from either?
bool has_two_sides(const Case& scene, const Wall& wall);

/// The walls for water that water or soil would be felt through: one place for each piece.
std::vector<ThinWall> thin_walls(const Case& scene);

/// Of coordinates, by rounding, in units of the margin.
inline constexpr double sight_slack = 1e-9;

/// The pieces of the walls for water as mirrors for a Sight: a line with two sides has one on each. They end where they
/// are drawn, but at a water face, behind which they go on for `margin` [m].
std::vector<sph::ImagePlane<2>> sides_of_walls(const Case& scene, double margin);

}  // namespace poretwin
