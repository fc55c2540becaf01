// The straight pieces of walls and faces (2D), their sides, and what lies opposite to them.
#pragma once

#include "common/case/case.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace poretwin {

/// Twice the area of the triangle that two vectors span in the plane; positive if v lies to the left of u.
inline double cross(const Point3& u, const Point3& v) { return u.x() * v.y() - u.y() * v.x(); }

struct Piece {
  Point3 a, b;
  [[nodiscard]] double length() const { return (b - a).norm(); }
  /// Unit vector to the left of the direction from a to b: into the domain.
  [[nodiscard]] Point3 left() const { return Point3(a.y() - b.y(), b.x() - a.x(), 0.0).normalized(); }
};

inline std::vector<Piece> pieces_of(const Face& face) {
  std::vector<Piece> result;
  for (std::size_t i = 0; i + 1 < face.points.size(); ++i) result.push_back({face.points[i], face.points[i + 1]});
  return result;
}

/// At least one place on the piece, in steps of about a spacing.
inline std::vector<Point3> places_along(const Piece& piece, double spacing) {
  const int parts = static_cast<int>(std::clamp(piece.length() / spacing, 1.0, 2000.0));
  std::vector<Point3> result;
  for (int k = 0; k < parts; ++k) result.emplace_back(piece.a + (k + 0.5) / parts * (piece.b - piece.a));
  return result;
}

/// Distance of x [m] from the piece.
inline double distance_from(const Piece& piece, const Point3& x) {
  const Point3 s = piece.b - piece.a;
  return (piece.a + std::clamp(s.dot(x - piece.a) / s.squaredNorm(), 0.0, 1.0) * s - x).norm();
}

/// Distance from x [m] along a direction (unit) to the piece; empty if the direction does not lead to it.
inline std::optional<double> distance_to(const Piece& piece, const Point3& x, const Point3& direction) {
  const Point3 s = piece.b - piece.a, d = piece.a - x;
  const double area = cross(direction, s);
  if (std::abs(area) < 1e-12 * s.norm()) return std::nullopt;
  const double t = cross(d, s) / area, u = cross(d, direction) / area;
  if (t < 0.0 || u < 0.0 || u > 1.0) return std::nullopt;
  return t;
}

}  // namespace poretwin
