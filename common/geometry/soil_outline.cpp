#include "common/geometry/soil_outline.hpp"

#include "common/geometry/extent.hpp"
#include "common/geometry/shapes.hpp"

#include <algorithm>

namespace poretwin {
namespace {

/// Parts of a piece shorter than this are rounding errors. In spacings.
constexpr double shortest = 1e-9;

/// A piece, divided at those of the points that lie on it.
std::vector<Piece> divided(const Piece& whole, std::span<const Point3> points, double spacing) {
  std::vector<double> cuts{0.0, whole.length()};
  const Point3 along = (whole.b - whole.a).normalized();
  for (const auto& x : points) {
    const double s = along.dot(x - whole.a);
    if (std::abs(cross(along, x - whole.a)) < beside_outline * spacing && s > 0.0 && s < whole.length())
      cuts.push_back(s);
  }
  std::sort(cuts.begin(), cuts.end());
  std::vector<Piece> parts;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i)
    if (cuts[i + 1] - cuts[i] >= shortest * spacing)
      parts.push_back({whole.a + cuts[i] * along, whole.a + cuts[i + 1] * along});
  return parts;
}

std::vector<Point3> corners_of_soils(const Case& scene) {
  std::vector<Point3> points;
  for (const auto& soil : scene.soils)
    for (const auto& x : corners_of(soil.shape, 2)) points.push_back(x);
  return points;
}

bool goes_along(const Face& face, const Piece& part, double near) {
  const Point3 middle = 0.5 * (part.a + part.b);
  if (face.points.empty()) return std::abs(face.normal.normalized().dot(middle - face.point)) < near;
  for (const auto& piece : pieces_of(face))
    if (distance_from(piece, middle) < near) return true;
  return false;
}

}  // namespace

std::vector<OutlinePart> soil_outline(const Case& scene, double spacing, std::span<const Face> faces) {
  std::vector<Point3> ends = corners_of_soils(scene);
  for (const auto& face : faces) ends.insert(ends.end(), face.points.begin(), face.points.end());
  const auto in_another = [&](std::size_t soil, const Point3& x) {
    for (std::size_t s = 0; s < scene.soils.size(); ++s)
      if (s != soil && contains(scene.soils[s].shape, x, 2)) return true;
    return false;
  };
  std::vector<OutlinePart> parts;
  std::size_t lines = 0;
  for (std::size_t s = 0; s < scene.soils.size(); ++s) {
    auto corners = corners_of(scene.soils[s].shape, 2);
    double twice_area = 0.0;
    for (std::size_t i = 0; i < corners.size(); ++i)
      twice_area += cross(corners[i] - corners[0], corners[(i + 1) % corners.size()] - corners[0]);
    if (twice_area < 0.0) std::reverse(corners.begin(), corners.end());
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Piece whole{corners[i], corners[(i + 1) % corners.size()]};
      const Point3 inwards = whole.left();
      // A side that continues another one is of the same line: a cell in front of both is cut off there once.
      const auto continued = std::find_if(parts.begin(), parts.end(), [&](const OutlinePart& part) {
        const double aside = beside_outline * spacing;
        const auto on_it = [&](const Point3& x) { return std::abs(part.piece.left().dot(x - part.piece.a)) < aside; };
        constexpr double parallel = 1.0 - 1e-6;
        return part.piece.left().dot(inwards) > parallel && on_it(whole.a) && on_it(whole.b);
      });
      const std::size_t line = continued == parts.end() ? lines++ : continued->line;
      for (const auto& piece : divided(whole, ends, spacing))
        if (!in_another(s, 0.5 * (piece.a + piece.b) - beside_outline * spacing * inwards))
          parts.push_back({piece, s, line});
    }
  }
  return parts;
}

std::vector<Piece> open_outline(const Case& scene, double spacing) {
  std::vector<Face> taken;
  for (const auto& wall : scene.walls)
    if (wall.water != Wall::ForWater::none) taken.push_back(wall.face);
  for (const auto& face : scene.water_faces) taken.push_back(face.face);
  for (const auto& rain : scene.rains) taken.push_back(rain.face);
  std::vector<Piece> open;
  for (const auto& part : soil_outline(scene, spacing, taken))
    if (std::none_of(taken.begin(), taken.end(),
                     [&](const Face& face) { return goes_along(face, part.piece, beside_outline * spacing); }))
      open.push_back(part.piece);
  return open;
}

std::vector<Piece> beside_no_soil(const Case& scene, double spacing, const Face& wall) {
  const auto ends = corners_of_soils(scene);
  std::vector<Piece> rest;
  for (const auto& whole : pieces_of(wall))
    for (const auto& piece : divided(whole, ends, spacing)) {
      const Point3 inside = 0.5 * (piece.a + piece.b) + beside_outline * spacing * piece.left();
      if (!soil_at(scene, inside)) rest.push_back(piece);
    }
  return rest;
}

}  // namespace poretwin
