// Whether two faces of a case lie on each other.
#pragma once

#include "common/geometry/loaded_part.hpp"
#include "common/geometry/pieces.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace poretwin {

/// A place [m] that lies on both faces, where they look to the same side along a common length or area; empty where
/// they only meet or cross. spacing [m]: of the particles. Parts that are cut out by other shapes than boxes along the
/// axes are not compared.
inline std::optional<Point3> shared_place(const Face& a, const Face& b, double spacing) {
  constexpr double same_direction = 1.0 - 1e-6;
  const double aside = 1e-3 * spacing;   // off the line or plane: rounding of the case's numbers
  const double common = 0.05 * spacing;  // ends that meet may be drawn so far over each other
  const auto on_plane = [&](const Face& plane, const Point3& x) {
    return std::abs(plane.normal.normalized().dot(x - plane.point)) < aside;
  };
  const auto whole_piece_on = [&](const Face& plane, const Face& lines) -> std::optional<Point3> {
    for (const Piece& piece : pieces_of(lines))
      if (plane.normal.normalized().dot(piece.left()) > same_direction && on_plane(plane, piece.a) &&
          on_plane(plane, piece.b))
        return Point3(0.5 * (piece.a + piece.b));
    return std::nullopt;
  };
  if (a.points.empty() && a.normal.isZero()) return std::nullopt;
  if (b.points.empty() && b.normal.isZero()) return std::nullopt;
  if (a.points.empty() && !b.points.empty()) return whole_piece_on(a, b);
  if (b.points.empty() && !a.points.empty()) return whole_piece_on(b, a);
  if (!a.points.empty()) {
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
  if (!(a.normal.normalized().dot(b.normal.normalized()) > same_direction) || !on_plane(a, b.point))
    return std::nullopt;
  Point3 place = b.point;
  Eigen::Index across = 0;
  a.normal.cwiseAbs().maxCoeff(&across);
  Point3 low = Point3::Constant(-HUGE_VAL), high = Point3::Constant(HUGE_VAL);
  for (const Face* face : {&a, &b}) {
    if (!face->within) continue;
    if (!plain_box(*face->within)) return std::nullopt;
    low = low.cwiseMax(face->within->min);
    high = high.cwiseMin(face->within->max);
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (axis == across || !std::isfinite(low[axis]) || !std::isfinite(high[axis])) continue;
    if (!(high[axis] - low[axis] > common)) return std::nullopt;
    place[axis] = 0.5 * (low[axis] + high[axis]);
  }
  return place;
}

}  // namespace poretwin
