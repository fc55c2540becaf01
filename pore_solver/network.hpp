// The soil's points, their Voronoi cells, and the connections between points and to the soil's border: the geometry of
// a two-point flux. A link connects two points whose cells touch. The line between the points is normal to their common
// face, so that the flux of a linear head is exact at any arrangement of the points (Eymard, Gallouet & Herbin 2000).
#pragma once

#include "common/case/case.hpp"
#include "common/core/vector.hpp"

#include <span>
#include <vector>

namespace poretwin::pore {

/// A pair of points whose cells touch. Everywhere in this solver, areas are lengths and volumes are areas in 2D. Across
/// a periodic side it links a with an image of b, which may be an image of a itself.
struct Link {
  Index a = 0, b = 0;
  double transmissibility = 0.0;   ///< area of the common face over the distance between the points, m (2D: 1)
  double of_a = 1.0, of_b = 1.0;   ///< conductivity of a's and b's soil along the link, over that along beds
  Point3 centre = Point3::Zero();  ///< m, centre of the common face
  double low = 0.0, high = 0.0;    ///< m, elevations of the face's lowest and highest corners
  Point3 shift = Point3::Zero();   ///< m, from b to its image; zero away from periodic sides
  double lift = 0.0;               ///< m, elevation of the image above b
};

/// A part of a cell's side on the soil's border, along a water face, under rain, or both; or the part of a well's
/// screen in a cell. A part of the border with neither face nor rain has no segment and is impermeable.
struct Segment {
  static constexpr std::size_t none = static_cast<std::size_t>(-1);
  Index point = 0;
  std::size_t face = none, rain = none, well = none;  ///< indices in the case's lists; a well has neither face nor rain
  double area = 0.0;                                  ///< m2 (2D: m)
  double level_area = 0.0;                            ///< m2 (2D: m), area of its horizontal projection
  double transmissibility = 0.0;   ///< m (2D: 1), area over the distance from the point to the border; for a
                                   ///< screen see add_wells()
  double across = 1.0;             ///< conductivity of the soil across the border over that along its beds
  Point3 centre = Point3::Zero();  ///< m
  double low = 0.0, high = 0.0;    ///< m, elevations of its lowest and highest point
};

/// The fraction of a cell that lies below an elevation.
struct Filling {
  double elevation = 0.0;  ///< m
  double share = 0.0;
};

struct Network {
  std::vector<Point3> position;      ///< m
  std::vector<std::size_t> soil;     ///< index in the case's list
  ScalarArray volume;                ///< of each cell, m3 (2D: m2)
  ScalarArray elevation;             ///< m, along -gravity
  std::vector<Filling> fillings;     ///< of all cells, at the elevations of their corners: fractions from 0 to 1
  std::vector<Index> first_filling;  ///< index of each cell's first filling; last entry: their number
  std::vector<Link> links;           ///< sorted by a, then b
  std::vector<Segment> segments;     ///< sorted by point
  [[nodiscard]] std::size_t size() const { return position.size(); }
  [[nodiscard]] std::span<const Filling> filling(Index a) const {
    return std::span(fillings).subspan(first_filling[a], first_filling[a + 1] - first_filling[a]);
  }
};

/// The network of a case, with cells that fit the soil's anisotropy (Stretch). For 3D see make_network_3d(). In 2D,
/// points one spacing apart fill each soil (`fill`), cells are cut off at the soils' common border, and no link passes
/// through a wall. Periodic sides are no border: points beside them are linked with images of those on the other side.
/// Beside a corner where the soil goes around a notch, a cell loses its part beyond the nearer side of the notch.
Network make_network(const Case& scene);
/// The network of a 2D case for points that the soil has displaced to the positions `now` [m]. drawn: result of
/// make_network() for the case. The border moves with the points beside it, in parts of a spacing. Throws DivergedError
/// where the border has folded over points.
Network make_network(const Case& scene, const Network& drawn, const std::vector<Point3>& now);

}  // namespace poretwin::pore
