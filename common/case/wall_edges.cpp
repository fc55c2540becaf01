#include "common/case/wall_edges.hpp"

#include "common/case/complaints.hpp"
#include "common/geometry/shapes.hpp"
#include "common/geometry/thin_walls.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>

namespace poretwin {
namespace {

/// Distance from an edge within which particles see images of both walls: the kernel's support [spacings].
constexpr double reach = 2.4;
/// Largest part of the space around an edge in which images may be missing or overlap, and cosine of the angles at
/// which it stays below that for two walls: 90 degrees and one more or less.
constexpr double allowed = 0.01, right_angle = 0.0175;
/// A rough base has no particle within 2.5 spacings of the edge of a sector of 11.25 degrees, so that grains fall
/// through it there; in sectors of 22.5 degrees none does (case column_collapse_3d).
constexpr double narrowest_on_rough = 22.4;  // degrees

struct Plane {
  std::size_t wall;
  Point3 point, normal;
  [[nodiscard]] double before(const Point3& x) const { return normal.dot(x - point); }
};

/// The walls that make images of one phase, and the bodies of the phase.
struct Scene {
  std::string_view what;             ///< soil or water
  double dx;                         ///< m
  bool can_move;                     ///< farther than it is drawn
  std::vector<Plane> planes, rough;  ///< rough: rows of particles in place of images
  std::vector<const Shape*> bodies;
};

struct Edge {
  std::size_t first, second;  ///< numbers of the walls
  double angle;               ///< degrees, on the side of the domain
  Point3 at;                  ///< m
  bool near;                  ///< soil or water lies there
  bool too_narrow;            ///< for the rough wall that crosses the edge there
  bool filled;                ///< images fill the space behind the edge once
};

class WallEdges : Complaints {
 public:
  WallEdges(const Case& scene, const Places& places) : Complaints(scene, places), d_(scene.general.dimension) {}

  void check() const {
    for (const Scene& scene : scenes())
      for (const Edge& edge : edges_of(scene)) {
        if (!edge.near) continue;
        if (!edge.filled)
          fail(fmt::format("wall[{}]", edge.second),
               meeting(edge) + fmt::format(", where {} lies. ", scene.what) + advice());
        if (edge.too_narrow)
          fail(fmt::format("wall[{}]", edge.second),
               meeting(edge) +
                   fmt::format(" on a wall with soil = \"rough\", whose rows have no particle near the edge: "
                               "expected a sector of 22.5 degrees or more, found {:.4g}",
                               edge.angle));
      }
  }

  [[nodiscard]] std::vector<std::string> doubts() const {
    std::vector<std::string> lines;
    std::set<std::pair<std::size_t, std::size_t>> known;
    for (const Scene& scene : scenes())
      for (const Edge& edge : edges_of(scene))
        if (scene.can_move && !edge.near && !edge.filled && known.emplace(edge.first, edge.second).second)
          lines.push_back(
              said(fmt::format("wall[{}]", edge.second),
                   meeting(edge) + fmt::format(": {} that comes there is computed wrongly. ", scene.what) + advice()));
    return lines;
  }

 private:
  [[nodiscard]] std::string meeting(const Edge& edge) const {
    return fmt::format("meets {} at an angle of {:.4g} degrees at {} m",
                       named("wall", edge.first, scene_.walls[edge.first].name), edge.angle, shown(edge.at));
  }
  [[nodiscard]] std::string advice() const {
    return fmt::format(
        "Images of planes leave a gap behind such an edge, or overlap: expected an angle of 90 degrees, {}",
        d_ == 3 ? "walls with a shape, or a sector of 45 or 22.5 degrees whose wall at this angle is followed by walls "
                  "at twice the angle, .., 90, and 0 degrees (case column_collapse_3d)"
                : "or walls by 'points'");
  }

  [[nodiscard]] std::vector<Scene> scenes() const {
    std::vector<Scene> found;
    if (scene_.deformable() && !scene_.soils.empty() && !(d_ == 2 && sight_matters(scene_, Keeps::soil))) {
      Scene soil{"soil", scene_.solid.particle_spacing, true, {}, {}, {}};
      bool by_surfaces = false;
      for (std::size_t w = 0; w < scene_.walls.size(); ++w) {
        const Wall& wall = scene_.walls[w];
        if (wall.soil == Wall::ForSoil::none) continue;
        if (wall.soil == Wall::ForSoil::rough) {
          add(w, soil.rough);
          continue;
        }
        by_surfaces = by_surfaces || wall.shape;
        add(w, soil.planes);
      }
      for (const Soil& s : scene_.soils) soil.bodies.push_back(&s.shape);
      if (!by_surfaces) found.push_back(std::move(soil));
    }
    if (scene_.has_water() && !scene_.is_field() && !(d_ == 2 && sight_matters(scene_, Keeps::water))) {
      Scene water{"water", scene_.fluid.particle_spacing, !scene_.fluid.regions.empty(), {}, {}, {}};
      bool by_surfaces = false;
      for (std::size_t w = 0; w < scene_.walls.size(); ++w) {
        if (scene_.walls[w].water == Wall::ForWater::none) continue;
        by_surfaces = by_surfaces || scene_.walls[w].shape;
        add(w, water.planes);
      }
      for (const Shape& region : scene_.fluid.regions) water.bodies.push_back(&region);
      for (const Soil& s : scene_.soils) water.bodies.push_back(&s.shape);
      if (!by_surfaces && !water.bodies.empty()) found.push_back(std::move(water));
    }
    return found;
  }
  void add(std::size_t w, std::vector<Plane>& planes) const {
    const Wall& wall = scene_.walls[w];
    if (!wall.shape && wall.face.points.empty()) planes.push_back({w, wall.face.point, wall.face.normal.normalized()});
  }

  /// The edges of the domain that are wrong, each where a body lies there, else anywhere in a box three times as large
  /// as that around the bodies.
  [[nodiscard]] std::vector<Edge> edges_of(const Scene& scene) const {
    Point3 low = Point3::Constant(HUGE_VAL), high = -low;
    for (const Shape* body : scene.bodies) {
      const auto [a, b] = bounds(*body);
      low = low.cwiseMin(a);
      high = high.cwiseMax(b);
    }
    if (d_ == 2) low.z() = high.z() = 0.0;
    const Point3 size = high - low;
    std::vector<Edge> found;
    for (std::size_t b = 0; b < scene.planes.size(); ++b)
      for (std::size_t a = 0; a < b; ++a)
        if (const auto edge = edge_of(scene, scene.planes[a], scene.planes[b], low - size, high + size))
          found.push_back(*edge);
    // Where several walls meet, the narrowest angle says most.
    std::ranges::stable_sort(found, {}, &Edge::angle);
    return found;
  }

  [[nodiscard]] std::optional<Edge> edge_of(const Scene& scene, const Plane& a, const Plane& b, const Point3& low,
                                            const Point3& high) const {
    const double facing = a.normal.dot(b.normal);
    if (std::abs(facing) > 1.0 - 1e-9 || std::abs(facing) < right_angle) return {};  // parallel, or sound
    const Point3 along = a.normal.cross(b.normal).normalized();
    // A point of both planes: a.point moved along a, down b.
    const Point3 down = (b.normal - facing * a.normal).normalized();
    const Point3 on = a.point - b.before(a.point) / b.normal.dot(down) * down;
    double from = -HUGE_VAL, to = HUGE_VAL;  // the part of the edge in the box
    for (int axis = 0; axis < d_; ++axis) {
      if (std::abs(along[axis]) < 1e-12) {
        if (on[axis] < low[axis] || on[axis] > high[axis]) return {};
        continue;
      }
      const double s = (low[axis] - on[axis]) / along[axis], t = (high[axis] - on[axis]) / along[axis];
      from = std::max(from, std::min(s, t));
      to = std::min(to, std::max(s, t));
    }
    if (d_ == 2) from = to = 0.0;
    if (!(from <= to)) return {};
    constexpr double most_places = 1e5;
    const double step = std::max(scene.dx, (to - from) / most_places);
    std::map<std::vector<bool>, bool> filled;  // by the planes within reach
    std::optional<Edge> far;
    for (double s = from; s <= to; s += step) {
      const Point3 x = on + s * along;
      if (std::ranges::any_of(scene.planes, [&](const Plane& p) { return p.before(x) < -1e-6 * scene.dx; })) continue;
      std::vector<bool> around;
      for (const Plane& p : scene.planes) around.push_back(p.before(x) < 2.0 * reach * scene.dx);
      Edge edge{a.wall, b.wall, 180.0 - std::acos(facing) * 180.0 / std::numbers::pi, x, false, false, true};
      if (!filled.contains(around)) filled[around] = is_filled(scene, x);
      edge.filled = filled[around];
      edge.too_narrow = edge.angle < narrowest_on_rough && on_rough(scene, x);
      if (edge.filled && !edge.too_narrow) continue;
      edge.near = near(scene, x);
      if (edge.near) return edge;
      far = edge;
    }
    return far;
  }

  [[nodiscard]] static bool on_rough(const Scene& scene, const Point3& x) {
    return std::ranges::any_of(scene.rough, [&](const Plane& p) { return std::abs(p.before(x)) < reach * scene.dx; });
  }

  /// Places in a ball around the origin, evenly spread (a lattice of irrational steps).
  [[nodiscard]] std::vector<Point3> ball(double radius) const {
    constexpr int tried = 1000;
    std::vector<Point3> places;
    for (int k = 1; k <= tried; ++k) {
      constexpr double step = 0.8191725133961645;  // root of x^4 + x^3 = 1 (Roberts 2018)
      Point3 x;
      for (int axis = 0; axis < 3; ++axis) x[axis] = 2.0 * std::fmod(k * std::pow(step, axis + 1), 1.0) - 1.0;
      if (d_ == 2) x.z() = 0.0;
      if (x.norm() <= 1.0) places.emplace_back(radius * x);
    }
    return places;
  }

  /// Whether a body lies within reach of a point of an edge.
  [[nodiscard]] bool near(const Scene& scene, const Point3& edge) const {
    const double away = reach * scene.dx;
    if (std::ranges::none_of(scene.bodies, [&](const Shape* body) {
          const auto [low, high] = bounds(*body);
          return ((edge - low).array() > -away).head(d_).all() && ((high - edge).array() > -away).head(d_).all();
        }))
      return false;
    return std::ranges::any_of(ball(reach * scene.dx), [&](const Point3& aside) {
      const Point3 x = edge + aside;
      return in_domain(scene, x) &&
             std::ranges::any_of(scene.bodies, [&](const Shape* body) { return contains(*body, x, d_); });
    });
  }
  [[nodiscard]] static bool in_domain(const Scene& scene, const Point3& x) {
    return std::ranges::all_of(scene.planes, [&](const Plane& p) { return p.before(x) >= 0.0; });
  }

  /// Number of images of points of the domain that lie at x. Each of them was made last by one of the first n planes.
  [[nodiscard]] static int images_at(const Scene& scene, const Point3& x, std::size_t n) {
    int sum = 0;
    for (std::size_t k = 0; k < n; ++k) {
      const Plane& plane = scene.planes[k];
      const double distance = plane.before(x);
      if (distance >= 0.0) continue;
      const Point3 original = x - 2.0 * distance * plane.normal;
      sum += (in_domain(scene, original) ? 1 : 0) + images_at(scene, original, k);
    }
    return sum;
  }
  /// Whether the images fill the space around a point of an edge once, outside the domain.
  [[nodiscard]] bool is_filled(const Scene& scene, const Point3& edge) const {
    int wrong = 0;
    const auto places = ball(reach * scene.dx);
    for (const Point3& aside : places) {
      const Point3 x = edge + aside;
      if (images_at(scene, x, scene.planes.size()) != (in_domain(scene, x) ? 0 : 1)) ++wrong;
    }
    return wrong <= allowed * static_cast<double>(places.size());
  }

  int d_;
};

}  // namespace

void check_wall_edges(const Case& scene, const Places& places) { WallEdges(scene, places).check(); }

std::vector<std::string> doubtful_wall_edges(const Case& scene, const Places& places) {
  return WallEdges(scene, places).doubts();
}

}  // namespace poretwin
