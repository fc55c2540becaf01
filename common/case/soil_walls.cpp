#include "common/case/soil_walls.hpp"

#include "common/case/amounts.hpp"
#include "common/case/complaints.hpp"
#include "common/geometry/extent.hpp"
#include "common/geometry/overlap.hpp"
#include "common/geometry/pieces.hpp"
#include "common/geometry/shapes.hpp"
#include "common/geometry/soil_outline.hpp"
#include "common/particles/neighbours.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace poretwin {
namespace {

class SoilWalls : Complaints {
 public:
  SoilWalls(const Case& scene, const Places& places)
      : Complaints(scene, places), d_(scene.general.dimension), dx_(scene.solid.particle_spacing) {}

  void all() const {
    loads_on_walls();
    loads_from_behind();
    for (std::size_t w = 0; w < scene_.walls.size(); ++w) {
      const Wall& wall = scene_.walls[w];
      if (wall.soil == Wall::ForSoil::none || wall.shape) continue;
      if (wall.face.points.empty())
        gap_to_boxes(w);
      else
        soil_in_front(w);
    }
    if (d_ != 2) return;
    gaps();
    cut_off();
  }

 private:
  /// A load on soil that a wall holds would act against the wall.
  void loads_on_walls() const {
    for (std::size_t i = 0; i < scene_.loads.size(); ++i)
      for (std::size_t w = 0; w < scene_.walls.size(); ++w) {
        const Wall& wall = scene_.walls[w];
        if (wall.soil == Wall::ForSoil::none || wall.shape || scene_.loads[i].on_all_sides()) continue;
        if (const auto place = shared_place(scene_.loads[i].face, wall.face, dx_))
          fail(fmt::format("load[{}]", i),
               fmt::format("lies on {} at {} m, which holds the soil there: expected a load on a free surface, or "
                           "soil = \"none\" for the wall",
                           named("wall", w, wall.name), shown(*place)));
      }
  }

  /// A pressure acts along the normal of its face: with the soil behind the face it would pull.
  void loads_from_behind() const {
    for (std::size_t i = 0; i < scene_.loads.size(); ++i) {
      const Load& load = scene_.loads[i];
      if (!load.pressure || load.on_all_sides()) continue;
      struct Plane {
        Point3 point, normal, along;
        double length;
      };
      std::vector<Plane> planes;
      for (const Piece& piece : pieces_of(load.face))
        planes.push_back({piece.a, piece.left(), (piece.b - piece.a).normalized(), piece.length()});
      if (planes.empty()) planes.push_back({load.face.point, load.face.normal.normalized(), Point3::Zero(), 0.0});
      bool before = false, behind = false;
      for (const Soil& soil : scene_.soils)
        for (const auto& x : places_in(soil.shape, dx_, d_))
          for (const Plane& plane : planes) {
            const double inside = plane.normal.dot(x - plane.point), along = plane.along.dot(x - plane.point);
            if (std::abs(inside) > dx_ || along < 0.0 || along > plane.length) continue;
            (inside > 0.0 ? before : behind) = true;
          }
      if (behind && !before)
        fail(fmt::format("load[{}]", i),
             fmt::format("the soil lies behind the load's face, and the pressure would pull at it: expected the soil "
                         "{}",
                         load.face.points.empty() ? "on the side to which 'normal' points"
                                                  : "on the left of the line: turn the order of the points round"));
    }
  }

  /// A wall acts on what lies on its left.
  void soil_in_front(std::size_t w) const {
    const Wall& wall = scene_.walls[w];
    for (const Piece& piece : pieces_of(wall.face)) {
      bool left = false;
      std::optional<Point3> right;
      for (const Point3& x : places_along(piece, dx_)) {
        const Point3 aside = 0.25 * dx_ * piece.left();
        left = left || soil_at(scene_, x + aside);
        if (soil_at(scene_, x - aside)) right = x;
      }
      if (!left && right)
        fail(fmt::format("wall[{}].points", w),
             fmt::format("soil lies to the right of the walk from {} to {}, for example at {} m; expected the soil on "
                         "the left: turn the order of the points round",
                         shown(piece.a), shown(piece.b), shown(*right)));
    }
  }

  // A row of particles lies half a spacing from its wall. Soil 0.3 spacings off a wall leant on it with half its
  // lateral stress, and bore 2.2 times its weight where it had fallen onto it. Particles farther than 1.2 spacings from
  // a wall do not interact with their images.
  static constexpr double touching = 0.05, apart = 0.7;  // spacings

  [[noreturn]] void gap(std::size_t soil, std::size_t w, double width, const Point3& at) const {
    fail(fmt::format("soil[{}]", soil),
         fmt::format("{} {:.3g} m {} {} at {} m, a part of a particle spacing: expected soil that ends on the wall, or "
                     "at least {:.3g} m from it",
                     width > 0.0 ? "leaves" : "reaches", std::abs(width), width > 0.0 ? "to" : "behind",
                     named("wall", w, scene_.walls[w].name), shown(at), apart * dx_));
  }

  /// Sides of soil along walls, but not on them.
  void gaps() const {
    constexpr double parallel = 1.0 - 1e-4, shortest = 3.0;  // cosine of an angle; spacings
    for (const OutlinePart& part : soil_outline(scene_, dx_, {}))
      for (std::size_t w = 0; w < scene_.walls.size(); ++w) {
        if (scene_.walls[w].soil == Wall::ForSoil::none) continue;
        for (const Piece& piece : pieces_of(scene_.walls[w].face)) {
          if (part.piece.left().dot(piece.left()) < parallel) continue;
          const Point3 along = (piece.b - piece.a).normalized();
          const double from = std::max(0.0, along.dot(part.piece.a - piece.a)),
                       to = std::min(piece.length(), along.dot(part.piece.b - piece.a));
          if (to - from < shortest * dx_) continue;
          const Point3 middle = piece.a + 0.5 * (from + to) * along;
          const double width = piece.left().dot(part.piece.a - middle);
          if (std::abs(width) > touching * dx_ && std::abs(width) < apart * dx_) gap(part.soil, w, width, middle);
        }
      }
  }

  /// Boxes beside walls that are planes or lines without end.
  void gap_to_boxes(std::size_t w) const {
    const Face& face = scene_.walls[w].face;
    const Point3 normal = face.normal.normalized();
    constexpr double along_axis = 1.0 - 1e-9;
    if (normal.cwiseAbs().maxCoeff() < along_axis) return;
    for (std::size_t s = 0; s < scene_.soils.size(); ++s) {
      const Shape& shape = scene_.soils[s].shape;
      if (!plain_box(shape)) continue;
      const double width = extent(shape, normal, d_).first - normal.dot(face.point);
      if (width > touching * dx_ && width < apart * dx_) gap(s, w, width, face.point);
    }
  }

  /// Whether a wall whose front is within a spacing of x [m] holds soil up: it faces upwards, or the soil is fixed to
  /// it.
  [[nodiscard]] bool is_held(const Point3& x, double spacing) const {
    const Point3 down = scene_.general.gravity.normalized();
    return std::ranges::any_of(scene_.walls, [&](const Wall& wall) {
      if (wall.soil == Wall::ForSoil::none) return false;
      const auto holds = [&](const Point3& normal) {
        const double facing = normal.dot(down);
        return wall.soil == Wall::ForSoil::fixed ? facing < 1e-6 : facing < -1e-6;
      };
      const auto in_front = [&](double away) { return away > 0.0 && away < spacing; };
      if (wall.face.points.empty()) {
        const Point3 normal = wall.face.normal.normalized();
        return holds(normal) && in_front(normal.dot(x - wall.face.point));
      }
      return std::ranges::any_of(pieces_of(wall.face), [&](const Piece& piece) {
        const double away = piece.left().dot(x - piece.a);
        return holds(piece.left()) && in_front(away) && distance_from(piece, x) < 1.001 * away;  // not past its ends
      });
    });
  }

  /// Refuses soil that walls divide into parts of which some are held up by nothing.
  void cut_off() const {
    const Point3& gravity = scene_.general.gravity;
    if (!scene_.solid.initial_rest || gravity.isZero()) return;
    for (const int axis : scene_.general.periodic)
      if (gravity[axis] != 0.0) return;
    std::vector<Piece> screens;
    for (const Wall& wall : scene_.walls)
      if (wall.soil != Wall::ForSoil::none)
        for (const Piece& piece : pieces_of(wall.face))
          if (std::ranges::any_of(places_along(piece, dx_),
                                  [&](const Point3& x) { return soil_at(scene_, x - 0.25 * dx_ * piece.left()); }))
            screens.push_back(piece);
    if (screens.empty()) return;
    double spacing = dx_;
    for (const Soil& soil : scene_.soils) spacing = std::max(spacing, spacing_to_look_at(soil.shape, dx_, d_));
    VecArray<2> points;
    for (const Soil& soil : scene_.soils)
      for (const auto& x : places_in(soil.shape, spacing, d_)) points.push_back(x.head<2>());
    const auto n = points.size();
    std::vector<std::size_t> part(n);
    std::iota(part.begin(), part.end(), std::size_t{0});
    const auto root = [&](std::size_t i) {
      while (part[i] != i) i = part[i] = part[part[i]];
      return i;
    };
    const auto point = [&](std::size_t i) { return Point3(points[i].x(), points[i].y(), 0.0); };
    const auto blocked = [&](const Point3& from, const Point3& to) {
      const Point3 way = to - from;
      return std::ranges::any_of(screens, [&](const Piece& piece) {
        const auto met = distance_to(piece, from, way.normalized());
        return met && *met < way.norm();
      });
    };
    const double reach = 1.5 * spacing;
    sph::CellGrid<2> grid;
    grid.build(points, reach);
    for (std::size_t i = 0; i < n; ++i)
      grid.for_each_within(points[i], reach, [&](Index j, double) {
        if (j < i && root(i) != root(j) && !blocked(point(i), point(j))) part[root(i)] = root(j);
      });
    std::vector<char> held(n, 0);
    for (std::size_t i = 0; i < n; ++i)
      if (!held[root(i)] && is_held(point(i), spacing)) held[root(i)] = 1;
    for (std::size_t i = 0; i < n; ++i)
      if (!held[root(i)])
        fail("soil", fmt::format("walls cut off a part of the soil, around {} m, and nothing holds that part up: "
                                 "expected soil on one side of a wall, or a [[wall]] under each part",
                                 shown(point(i))));
  }

  int d_;
  double dx_;
};

}  // namespace

void check_soil_walls(const Case& scene, const Places& places) { SoilWalls(scene, places).all(); }

}  // namespace poretwin
