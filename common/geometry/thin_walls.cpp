#include "common/geometry/thin_walls.hpp"

#include "common/case/amounts.hpp"
#include "common/geometry/pieces.hpp"
#include "common/geometry/shapes.hpp"
#include "common/media/seepage.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin {
namespace {

bool lies_in(const Case& scene, Keeps what, const Point3& x) {
  return what == Keeps::water ? in_fluid_region(scene, x) : soil_at(scene, x) != nullptr;
}
double spacing_of(const Case& scene, Keeps what) {
  return what == Keeps::water ? scene.fluid.particle_spacing : scene.solid.particle_spacing;
}
/// Whether the wall makes images of these particles.
bool stops(const Wall& wall, Keeps what) {
  return what == Keeps::water ? wall.water != Wall::ForWater::none
                              : wall.soil != Wall::ForSoil::none && wall.soil != Wall::ForSoil::rough;
}

/// A place where water or soil lies on both sides of a line.
std::optional<Point3> two_sides(const Case& scene, Keeps what, const Piece& piece) {
  const double dx = spacing_of(scene, what);
  const Point3 aside = 1e-3 * dx * piece.left();
  for (const auto& x : places_along(piece, dx))
    if (lies_in(scene, what, x + aside) && lies_in(scene, what, x - aside)) return x;
  return std::nullopt;
}

/// Whether x lies on one of the pieces.
bool lies_on(const std::vector<Piece>& pieces, const Point3& x, double tolerance) {
  return std::any_of(pieces.begin(), pieces.end(), [&](const Piece& p) { return distance_from(p, x) < tolerance; });
}

/// Adds a wall as a mirror on its left and, if it is a line with particles on both sides, on its right.
void add_sides(const Case& scene, Keeps what, const Wall& wall, int number, int& screen, double margin,
               std::vector<sph::ImagePlane<2>>& planes) {
  const double near = 1e-6 * margin;
  const auto pieces = pieces_of(wall.face);
  std::vector<Piece> faces;
  for (const auto& face : scene.water_faces)
    for (const auto& piece : pieces_of(face.face)) faces.push_back(piece);
  const bool both = has_two_sides(scene, wall, what);
  if (wall.face.points.empty()) {
    auto plane = planes_of<2>(wall.face, number, 0.0)[0];
    plane.tangent = Vec<2>(plane.normal.y(), -plane.normal.x());
    plane.seen_from = -1e6 * margin;
    plane.seen_to = 1e6 * margin;
    plane.screen = screen++;
    planes.push_back(plane);
  }
  // How far a line continues beyond an end, as seen by particles: behind a water face by the margin. At a free tip it
  // ends slightly earlier; otherwise particles on opposite sides, at equal distances from the line, would not see each
  // other past the tip (seepage 2.5 % too small with 15 spacings).
  const auto goes_on = [&](const Piece& piece, const Point3& end) {
    // Where the wall continues straight into a face, pairs that cross the face see each other past the wall (Joint).
    const Point3 along = (piece.b - piece.a).normalized();
    const bool turns = std::any_of(faces.begin(), faces.end(), [&](const Piece& face) {
      return std::abs(along.dot((face.b - face.a).normalized())) < 0.99 && lies_on({face}, end, near);
    });
    if (turns) return margin;
    const auto meets = [&](const Wall& other) {
      auto theirs = pieces_of(other.face);
      std::erase_if(theirs, [&](const Piece& p) { return p.a == piece.a && p.b == piece.b; });
      return lies_on(theirs, end, near);
    };
    return both && std::none_of(scene.walls.begin(), scene.walls.end(), meets) ? -10.0 * sight_slack * margin : 0.0;
  };
  for (const auto& piece : pieces) {
    for (const bool back : {false, true}) {
      if (back && !both) continue;
      const Point3 &start = back ? piece.b : piece.a, &end = back ? piece.a : piece.b;
      const Vec<2> a = start.head<2>(), b = end.head<2>();
      sph::ImagePlane<2> plane;
      plane.point = a;
      plane.tangent = (b - a).normalized();
      plane.normal = Vec<2>(-plane.tangent.y(), plane.tangent.x());
      plane.seen_from = plane.tangent.dot(a) - goes_on(piece, start);
      plane.seen_to = plane.tangent.dot(b) + goes_on(piece, end);
      plane.from = plane.seen_from - margin;
      plane.to = plane.seen_to + margin;
      plane.boundary = number;
      plane.screen = screen;
      plane.back = back;
      planes.push_back(plane);
    }
    ++screen;
  }
}

/// Whether all water seeps through soil of one conductivity.
bool seeps_through_one_soil(const Case& scene) {
  if (porous::conductivity_contrast(scene) >= porous::one_conductivity) return false;
  for (const auto& region : scene.fluid.regions)
    for (const auto& x :
         fill<2>(region, spacing_to_look_at(region, scene.fluid.particle_spacing, 2), {0.5, 0.5, 0.5}, 0.0, 1).position)
      if (!soil_at(scene, Point3(x.x(), x.y(), 0.0))) return false;
  return true;
}

}  // namespace

bool has_two_sides(const Case& scene, const Wall& wall, Keeps what) {
  if (scene.general.dimension != 2) return false;
  const auto pieces = pieces_of(wall.face);
  return std::any_of(pieces.begin(), pieces.end(),
                     [&](const Piece& p) { return two_sides(scene, what, p).has_value(); });
}

std::optional<std::string> hinders_sight(const Case& scene, Keeps what) {
  if (scene.general.dimension != 2) return "in three dimensions";
  if (!scene.general.periodic.empty()) return "between periodic sides";
  if (what == Keeps::soil) {
    if (scene.coupled()) return "where its pore water is solved for";
    if (!scene.plates.empty()) return "beside a plate";
    return std::nullopt;
  }
  if (scene.deformable()) return "beside soil that moves";
  for (const auto& face : scene.water_faces) {
    if (is_inlet(scene, face)) return "beside an inlet";
    const auto crest = is_reservoir(scene, face) ? crest_of(scene, face) : std::nullopt;
    if (!crest || !no_way_over(scene, *crest).empty()) continue;
    if (face.basin_area || std::any_of(face.head->knots.begin(), face.head->knots.end(),
                                       [&](const auto& knot) { return knot.second > crest->elevation; }))
      return "where a reservoir runs over";
  }
  return std::nullopt;
}

bool sight_matters(const Case& scene, Keeps what) {
  if (hinders_sight(scene, what)) return false;
  if (!thin_walls(scene, what).empty()) return true;
  if (what == Keeps::soil) return false;
  std::vector<Piece> walls, faces;
  for (const auto& wall : scene.walls)
    if (wall.water != Wall::ForWater::none)
      for (const auto& piece : pieces_of(wall.face)) walls.push_back(piece);
  for (const auto& face : scene.water_faces)
    for (const auto& piece : pieces_of(face.face)) faces.push_back(piece);
  const double dx = scene.fluid.particle_spacing, near = 0.05 * dx;
  const bool one_soil = seeps_through_one_soil(scene);
  const auto along = [](const Piece& p) { return Point3((p.b - p.a).normalized()); };
  const auto free_before = [&](const Piece& piece, const Point3& end) {
    const Point3 inwards = (piece.a + piece.b - 2.0 * end).normalized();
    return !soil_at(scene, end + 0.25 * dx * (piece.left() + inwards));
  };
  for (const auto& wall : walls) {
    for (const auto& next : walls)
      if ((wall.b - next.a).norm() < near && wall.left().dot(along(next)) < -0.01 &&
          (one_soil || free_before(wall, wall.b) || free_before(next, next.a)))
        return true;
    if (!one_soil) continue;
    for (const auto& face : faces) {
      if ((wall.b - face.a).norm() < near && wall.left().dot(along(face)) <= 0.01) return true;
      if ((wall.a - face.b).norm() < near && face.left().dot(along(wall)) <= 0.01) return true;
    }
  }
  return false;
}

/// A wall with particles on both sides needs a thickness of 5 spacings (two kernel reaches), a wall with particles on
/// one side 3 spacings (one reach), unless `Sight` prevents interaction through it. Measured without `Sight`: at 5
/// spacings and more, still water on both sides stays at rest (at 4 it moves at 0.7 m/s, at 2 the run diverges), and
/// seepage is right (1.4 % wrong at 4, NaN at 3). Water on one side is right at 3 spacings and more (at 1 its pressure
/// is 7 % too high). The sides of a wedge, such as a dike with steep slopes, are thin near its edge; where they meet at
/// about a right angle or more, the wall has a corner there, and is not thin.
std::vector<ThinWall> thin_walls(const Case& scene, Keeps what) {
  std::vector<ThinWall> found;
  if (scene.general.dimension != 2 || !(what == Keeps::water ? scene.has_water() : scene.deformable())) return found;
  const double dx = spacing_of(scene, what);
  struct Side {
    std::size_t wall;
    Piece piece;
  };
  std::vector<Side> sides;
  for (std::size_t i = 0; i < scene.walls.size(); ++i)
    if (stops(scene.walls[i], what))
      for (const auto& piece : pieces_of(scene.walls[i].face)) sides.push_back({i, piece});
  const auto first = [&](const Side& p) -> std::optional<ThinWall> {
    const Point3 left = p.piece.left();
    if (const auto x = two_sides(scene, what, p.piece)) return ThinWall{p.wall, *x, 0.0, 5.0 * dx, true};
    for (const auto& q : sides) {
      const Point3 across = q.piece.left();
      if (left.dot(across) > -0.1) continue;
      for (const auto& x : places_along(p.piece, dx)) {
        const auto thickness = distance_to(q.piece, x, across);
        if (!thickness || !(*thickness > 0.0) || *thickness >= 5.0 * dx) continue;
        if (!lies_in(scene, what, x + 0.25 * dx * left)) continue;
        const bool both = lies_in(scene, what, x + (*thickness + 0.25 * dx) * across);
        const double least = (both ? 5.0 : 3.0) * dx;
        if (*thickness < (1.0 - 1e-6) * least) return ThinWall{p.wall, x, *thickness, least, both};
      }
    }
    return std::nullopt;
  };
  for (const auto& p : sides)
    if (const auto thin = first(p)) found.push_back(*thin);
  return found;
}

std::vector<sph::ImagePlane<2>> sides_of_walls(const Case& scene, Keeps what, double margin) {
  std::vector<sph::ImagePlane<2>> planes;
  int screen = 0;
  for (std::size_t w = 0; w < scene.walls.size(); ++w)
    if (stops(scene.walls[w], what))
      add_sides(scene, what, scene.walls[w], static_cast<int>(w), screen, margin, planes);
  // Where a line turns away from the domain or continues straight, some points see both of its pieces. A line of sight
  // through the common end then counts for the first piece only.
  for (auto& plane : planes)
    for (const auto& before : planes)
      if (before.screen != plane.screen && before.tangent.dot(plane.tangent) > -0.99 &&
          (before.at(before.seen_to) - plane.at(plane.seen_from)).norm() < 1e-6 * margin &&
          before.normal.dot(plane.tangent) <= 0.01)
        plane.taken = true;
  return planes;
}

}  // namespace poretwin
