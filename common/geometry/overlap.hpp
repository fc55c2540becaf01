// Whether two faces of a case lie on each other.
#pragma once

#include "common/geometry/loaded_part.hpp"
#include "common/geometry/pieces.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace poretwin {

namespace overlap {

constexpr double same_direction = 1.0 - 1e-6;

inline bool on_plane(const Face& plane, const Point3& x, double aside) {
  return std::abs(plane.normal.normalized().dot(x - plane.point)) < aside;
}

/// A place of a whole piece of `lines` that lies on the plane.
inline std::optional<Point3> of_plane_and_lines(const Face& plane, const Face& lines, double aside) {
  for (const Piece& piece : pieces_of(lines))
    if (plane.normal.normalized().dot(piece.left()) > same_direction && on_plane(plane, piece.a, aside) &&
        on_plane(plane, piece.b, aside))
      return Point3(0.5 * (piece.a + piece.b));
  return std::nullopt;
}

/// common [m]: least length along which the lines lie on each other.
inline std::optional<Point3> of_lines(const Face& a, const Face& b, double aside, double common) {
  for (const Piece& p : pieces_of(a))
    for (const Piece& q : pieces_of(b)) {
      if (!(p.left().dot(q.left()) > same_direction)) continue;
      const Point3 along = (p.b - p.a).normalized();
      if (!(std::abs(cross(along, q.a - p.a)) < aside)) continue;
      const double from = std::max(0.0, along.dot(q.a - p.a)), to = std::min(p.length(), along.dot(q.b - p.a));
      if (to - from > common) return Point3(p.a + 0.5 * (from + to) * along);
    }
  return std::nullopt;
}

/// common [m]: least width of the area that the planes share.
inline std::optional<Point3> of_planes(const Face& a, const Face& b, double aside, double common) {
  if (!(a.normal.normalized().dot(b.normal.normalized()) > same_direction) || !on_plane(a, b.point, aside))
    return std::nullopt;
  Eigen::Index across = 0;
  a.normal.cwiseAbs().maxCoeff(&across);
  Point3 low = Point3::Constant(-HUGE_VAL), high = Point3::Constant(HUGE_VAL);
  for (const Face* face : {&a, &b}) {
    if (!face->within) continue;
    if (!plain_box(*face->within)) return std::nullopt;
    low = low.cwiseMax(face->within->min);
    high = high.cwiseMin(face->within->max);
  }
  Point3 place = b.point;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis == across || !std::isfinite(low[axis]) || !std::isfinite(high[axis])) continue;
    if (!(high[axis] - low[axis] > common)) return std::nullopt;
    place[axis] = 0.5 * (low[axis] + high[axis]);
  }
  return place;
}

}  // namespace overlap

/// A place [m] that lies on both faces, where they look to the same side along a common length or area; empty where
/// they only meet or cross. spacing [m]: of the particles. Parts that are cut out by other shapes than boxes along the
/// axes are not compared.
inline std::optional<Point3> shared_place(const Face& a, const Face& b, double spacing) {
  const double aside = 1e-3 * spacing;   // off the line or plane: rounding of the case's numbers
  const double common = 0.05 * spacing;  // ends that meet may be drawn so far over each other
  const auto is_absent = [](const Face& face) { return face.points.empty() && face.normal.isZero(); };
  if (is_absent(a) || is_absent(b)) return std::nullopt;
  if (!a.points.empty() && !b.points.empty()) return overlap::of_lines(a, b, aside, common);
  if (!a.points.empty()) return overlap::of_plane_and_lines(b, a, aside);
  if (!b.points.empty()) return overlap::of_plane_and_lines(a, b, aside);
  return overlap::of_planes(a, b, aside, common);
}

}  // namespace poretwin
