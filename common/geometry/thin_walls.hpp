// Walls through which a kernel reaches: thinner than its support, or lines with water or soil on both sides (2D).
#pragma once

#include "common/case/case.hpp"
#include "common/particles/images.hpp"

#include <optional>
#include <string>
#include <vector>

namespace poretwin {

/// The particles that a wall separates: those of the water, in soil or free, or those of soil that moves.
enum class Keeps { water, soil };

/// A place at which a wall is thin.
struct ThinWall {
  std::size_t wall = 0;
  Point3 at = Point3::Zero();  ///< m
  double thickness = 0.0;      ///< m; 0 for a line
  double least = 0.0;          ///< least thickness through which no kernel reaches [m]
  bool both_sides = false;     ///< water or soil stands on both sides
};

/// The reason why lines of sight past walls cannot separate particles; empty if they can. For water they can in 2D, in
/// soil at rest or without soil, without inlets, overflowing reservoirs and periodic sides. For soil they can in 2D,
/// without pore water that is solved for, plates and periodic sides.
std::optional<std::string> hinders_sight(const Case& scene, Keeps what);

/// Whether a line of sight past walls is needed, in a scene that allows it. It is needed where walls are thin, and for
/// free water at corners at which a wall turns away from it: images that the bisector of such a corner divides are not
/// seen alike from both ends, so that the two weights of a pair differ. For water that seeps only through one soil it
/// is also needed at such corners in soil and at ends where a water face continues the wall: there the velocity has no
/// bound, and pairs that are counted twice, or from one side only, become visible in the water balance.
bool sight_matters(const Case& scene, Keeps what);

/// Whether water, in soil or free, or soil lies on both sides of the wall, so that the wall is a line with two sides.
bool has_two_sides(const Case& scene, const Wall& wall, Keeps what);

/// The walls through which kernels reach, with one place for each piece.
std::vector<ThinWall> thin_walls(const Case& scene, Keeps what);

/// Error of coordinates by rounding, as a fraction of the margin.
inline constexpr double sight_slack = 1e-9;

/// The pieces of the walls as mirrors for a Sight, with the wall's number as boundary. A line with two sides has a
/// mirror on each. The pieces end where they are drawn, but continue for `margin` [m] behind a water face.
std::vector<sph::ImagePlane<2>> sides_of_walls(const Case& scene, Keeps what, double margin);

}  // namespace poretwin
