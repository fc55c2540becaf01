// The soil's points, their Voronoi cells, and what connects them to each other and to the soil's border: the geometry
// of a two-point flux. A link carries area over distance between two points whose cells touch, and the line between
// them is normal to that area, so that the flux of a linear head is exact however the points lie (Eymard, Gallouet &
// Herbin 2000).
#pragma once

#include "common/case/case.hpp"
#include "common/core/vector.hpp"

#include <span>
#include <vector>

namespace poretwin::pore {

/// Two points whose cells touch. In 2D areas are lengths and volumes are areas, as everywhere in this solver.
struct Link {
  Index a = 0, b = 0;
  double transmissibility = 0.0;  ///< area of the common face over the distance between the points, m (2D: 1)
  Point3 centre;                  ///< of the face, m
  double low = 0.0, high = 0.0;   ///< m, elevations of the face's lowest and highest corner
};

/// Where a cell meets the soil's border: on a water face, under rain, or on both. A border that carries neither has no
/// segment, and lets nothing through.
struct Segment {
  static constexpr std::size_t none = static_cast<std::size_t>(-1);
  Index point = 0;
  std::size_t face = none, rain = none;  ///< index in the case's lists
  double area = 0.0;                     ///< m2 (2D: m)
  double level_area = 0.0;               ///< of its projection on the horizontal
  double transmissibility = 0.0;         ///< area over the distance from the point to the border
  Point3 centre;                         ///< m
  double low = 0.0, high = 0.0;          ///< m, elevations
};

/// What share of a cell lies below an elevation.
struct Filling {
  double elevation = 0.0;  ///< m
  double share = 0.0;
};

struct Network {
  std::vector<Point3> position;      ///< m
  std::vector<std::size_t> soil;     ///< index in the case's list
  ScalarArray volume;                ///< of each cell, m3 (2D: m2)
  ScalarArray elevation;             ///< m, along -gravity
  std::vector<Filling> fillings;     ///< of all cells, at the elevations of their corners, rising from 0 to 1
  std::vector<Index> first_filling;  ///< of each cell, and the end of the last
  std::vector<Link> links;           ///< by a, then b
  std::vector<Segment> segments;     ///< by point
  [[nodiscard]] std::size_t size() const { return position.size(); }
  [[nodiscard]] std::span<const Filling> filling(Index a) const {
    return std::span(fillings).subspan(first_filling[a], first_filling[a + 1] - first_filling[a]);
  }
};

/// Of a case in 2D: points a spacing apart fill each soil (`fill`), cells are cut off at the soils' common border, and
/// links do not pass through walls. Beside a corner at which the soil goes around a notch a cell loses what lies beyond
/// the nearer side of the notch.
Network make_network(const Case& scene);
/// Of the same points where soil has carried them to; `drawn`: make_network() of the case. The border goes with the
/// points beside it, divided into parts of a spacing. Throws DivergedError where it has folded over points.
Network make_network(const Case& scene, const Network& drawn, const std::vector<Point3>& now);

}  // namespace poretwin::pore
