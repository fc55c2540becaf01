// Flat convex polygons in space. They are the sides of cells in 3D.
#pragma once

#include "common/case/case.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <vector>

namespace poretwin::pore {

/// Corners in their order around the polygon, in either direction of rotation.
using Polygon = std::vector<Point3>;

struct Measure {
  Point3 normal = Point3::Zero();  ///< unit, by the right-hand rule from the corners' order
  Point3 centre = Point3::Zero();  ///< centre of area
  double area = 0.0;
};

inline Measure measure(const Polygon& polygon) {
  Measure m;
  if (polygon.size() < 3) return m;
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    m.normal += 0.5 * (polygon[i] - polygon[0]).cross(polygon[i + 1] - polygon[0]);
  m.area = m.normal.norm();
  if (!(m.area > 0.0)) return Measure{};
  m.normal /= m.area;
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
    const double part = 0.5 * m.normal.dot((polygon[i] - polygon[0]).cross(polygon[i + 1] - polygon[0]));
    m.centre += part / (3.0 * m.area) * (polygon[0] + polygon[i] + polygon[i + 1]);
  }
  return m;
}

/// The part of a polygon where direction . x <= limit; empty if no part satisfies it.
inline Polygon below(const Polygon& polygon, const Point3& direction, double limit) {
  Polygon part;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double p = direction.dot(a) - limit, q = direction.dot(b) - limit;
    if (p <= 0.0) part.push_back(a);
    if ((p < 0.0 && q > 0.0) || (p > 0.0 && q < 0.0)) part.emplace_back(a + p / (p - q) * (b - a));
  }
  return part;
}

/// Divides a polygon into triangles around its centre, and each triangle into 4^divisions equal triangles.
inline std::vector<Polygon> triangles_of(const Polygon& polygon, int divisions) {
  std::vector<Polygon> parts;
  const Point3 centre = measure(polygon).centre;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    parts.push_back({centre, polygon[i], polygon[(i + 1) % polygon.size()]});
  for (int d = 0; d < divisions; ++d) {
    std::vector<Polygon> finer;
    for (const auto& t : parts) {
      const Point3 ab = 0.5 * (t[0] + t[1]), bc = 0.5 * (t[1] + t[2]), ca = 0.5 * (t[2] + t[0]);
      for (const Polygon& quarter :
           {Polygon{t[0], ab, ca}, Polygon{t[1], bc, ab}, Polygon{t[2], ca, bc}, Polygon{ab, bc, ca}})
        finer.push_back(quarter);
    }
    parts = std::move(finer);
  }
  return parts;
}

}  // namespace poretwin::pore
