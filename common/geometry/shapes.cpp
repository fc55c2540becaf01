#include "common/geometry/shapes.hpp"

#include "common/geometry/pieces.hpp"

#include "common/geometry/extent.hpp"
#include "common/geometry/packing.hpp"
#include "common/geometry/solid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>

namespace poretwin {

bool contains(const Shape& shape, const Point3& x, int dimension) {
  if (shape.solid) return shape.solid->contains(x);
  if (shape.kind == Shape::Kind::box) {
    for (int d = 0; d < dimension; ++d)
      if (x[d] < shape.min[d] || x[d] > shape.max[d]) return false;
    return true;
  }
  if (shape.kind == Shape::Kind::ball) return (x - shape.centre).head(dimension).norm() <= shape.radius;
  // The point is inside where a ray crosses the edges an odd number of times (Shimrat 1962).
  bool inside = false;
  const auto& p = shape.points;
  for (std::size_t i = 0, j = p.size() - 1; i < p.size(); j = i++)
    if ((p[i].y() > x.y()) != (p[j].y() > x.y()) &&
        x.x() < (p[j].x() - p[i].x()) * (x.y() - p[i].y()) / (p[j].y() - p[i].y()) + p[i].x())
      inside = !inside;
  return inside;
}

const Soil* soil_at(const Case& scene, const Point3& x) {
  for (const auto& soil : scene.soils)
    if (contains(soil.shape, x, scene.general.dimension)) return &soil;
  return nullptr;
}

bool in_fluid_region(const Case& scene, const Point3& x) {
  return std::ranges::any_of(scene.fluid.regions,
                             [&](const Shape& region) { return contains(region, x, scene.general.dimension); });
}

std::pair<Point3, Point3> bounds(const Shape& shape) {
  if (shape.solid) return shape.solid->bounds();
  if (shape.kind == Shape::Kind::box) return {shape.min, shape.max};
  if (shape.kind == Shape::Kind::ball)
    return {shape.centre - Point3::Constant(shape.radius), shape.centre + Point3::Constant(shape.radius)};
  Point3 lower = shape.points.front(), upper = lower;
  for (const auto& p : shape.points) {
    lower = lower.cwiseMin(p);
    upper = upper.cwiseMax(p);
  }
  return {lower, upper};
}

Point3 sloshing_mode(const Shape& shape, const Point3& x, int dimension) {
  const auto [lower, upper] = bounds(shape);
  const int up = dimension - 1;
  const double k = std::numbers::pi / (upper[0] - lower[0]), depth = upper[up] - lower[up];
  const double s = k * (x[0] - lower[0]), z = k * (x[up] - lower[up]);
  Point3 v = Point3::Zero();
  v[0] = std::sin(s) * std::cosh(z) / std::sinh(k * depth);
  v[up] = -std::cos(s) * std::sinh(z) / std::sinh(k * depth);
  return v;
}

namespace {

/// Whether x lies on an edge of a polygon, to within rounding.
bool on_edge(const Shape& shape, const Point3& x, double slack) {
  if (shape.kind != Shape::Kind::polygon) return false;
  const auto& p = shape.points;
  for (std::size_t i = 0, j = p.size() - 1; i < p.size(); j = i++) {
    const Point3 edge = p[i] - p[j], from = x - p[j];
    const double along = std::clamp(from.head<2>().dot(edge.head<2>()) / edge.head<2>().squaredNorm(), 0.0, 1.0);
    if ((from - along * edge).head<2>().norm() < slack) return true;
  }
  return false;
}

}  // namespace

namespace {

/// Fills a rectangle with rows along its sides, as in a box. If rows met a wall at an angle, particles would be at any
/// distance from it, and stresses within five rows of it would be wrong by up to a third of the stress at the base.
Lattice<2> fill_turned(const Point3& corner, const std::array<Point3, 2>& sides, double spacing, const Point3& offset,
                       double jitter, unsigned seed) {
  Lattice<2> lattice;
  std::array<int, 2> count{};
  std::array<Point3, 2> step;
  lattice.volume = 1.0;
  for (std::size_t d = 0; d < 2; ++d) {
    count[d] = std::max(1, static_cast<int>(std::lround(sides[d].norm() / spacing)));
    step[d] = sides[d] / count[d];
    lattice.volume *= step[d].norm();
  }
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> displacement(-jitter, jitter);
  for (int j = 0; j < count[1]; ++j)
    for (int i = 0; i < count[0]; ++i) {
      double a = i + offset[0], b = j + offset[1];
      if (jitter > 0.0) {
        a += displacement(generator);
        b += displacement(generator);
      }
      lattice.position.emplace_back((corner + a * step[0] + b * step[1]).head<2>());
    }
  return lattice;
}

/// The box as the case draws it, before it is scaled, turned and moved; empty unless the shape is a placed box (3D).
std::optional<Shape> turned_box(const Shape& shape) {
  if (!shape.solid || shape.kind != Shape::Kind::box || shape.solid->parts().size() > 1) return std::nullopt;
  Shape drawn;
  drawn.min = shape.min;
  drawn.max = shape.max;
  return drawn;
}

}  // namespace

bool is_packed(const Shape& shape) { return shape.solid && !turned_box(shape); }

template <int D>
Lattice<D> fill(const Shape& shape, double spacing, const Point3& offset, double jitter, unsigned seed,
                std::span<const Shape> later) {
  Lattice<D> lattice;
  if constexpr (D == 2) {
    if (const auto sides = turned_rectangle(shape))
      return fill_turned(shape.points[0], *sides, spacing, offset, jitter, seed);
  }
  if constexpr (D == 3) {
    if (const auto as_drawn = turned_box(shape)) {
      lattice = fill<3>(*as_drawn, spacing / shape.placement->scale, offset, jitter, seed);
      for (auto& x : lattice.position) x = placed(*shape.placement, x, 3);
      lattice.volume *= std::pow(shape.placement->scale, 3);
      return lattice;
    }
    if (shape.solid) return deepest_in(*shape.solid, spacing, offset);
  }
  const auto [lower, upper] = bounds(shape);
  std::array<int, 3> count{1, 1, 1};
  Point3 step = Point3::Zero();
  lattice.volume = 1.0;
  for (int d = 0; d < D; ++d) {
    const double length = upper[d] - lower[d];
    count[static_cast<std::size_t>(d)] = std::max(1, static_cast<int>(std::lround(length / spacing)));
    step[d] = length / count[static_cast<std::size_t>(d)];
    lattice.volume *= step[d];
  }
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> displacement(-jitter, jitter);
  for (int k = 0; k < count[2]; ++k)
    for (int j = 0; j < count[1]; ++j)
      for (int i = 0; i < count[0]; ++i) {
        Point3 x = Point3::Zero();
        const Point3 cell(i, j, k);
        for (int d = 0; d < D; ++d) x[d] = lower[d] + (cell[d] + offset[d]) * step[d];
        const auto bounds_it = [&](const Shape& other) { return on_edge(other, x, 1e-6 * spacing); };
        const bool inside =
            bounds_it(shape) ? std::any_of(later.begin(), later.end(), bounds_it) : contains(shape, x, D);
        if (!inside) continue;
        if (jitter > 0.0)
          for (int d = 0; d < D; ++d) x[d] += displacement(generator) * step[d];
        lattice.position.push_back(x.template head<D>());
      }
  return lattice;
}

template <int D>
Lattice<D> lay(const Shape& shape, double spacing, const Point3& offset, double jitter, unsigned seed,
               std::span<const Shape> later) {
  auto lattice = fill<D>(shape, spacing, offset, jitter, seed, later);
  if constexpr (D == 3)
    if (is_packed(shape)) pack(*shape.solid, spacing, lattice);
  return lattice;
}

bool is_inlet(const Case& scene, const WaterFace& face) {
  const auto& points = face.face.points;
  if (face.basin_area || points.size() < 2 || (!face.discharge && !face.head)) return false;
  const double spacing = scene.fluid.particle_spacing;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Point3 along = points[i + 1] - points[i], left = Point3(-along.y(), along.x(), 0.0).normalized();
    const int parts = std::clamp(static_cast<int>(along.norm() / spacing), 1, 10000);
    for (int k = 0; k < parts; ++k) {
      const Point3 x = points[i] + (k + 0.5) / parts * along + 0.25 * spacing * left;
      if (soil_at(scene, x)) return false;
    }
  }
  return true;
}

double distance_from(const Face& face, const Point3& x, int dimension) {
  double nearest = HUGE_VAL;
  for (const auto& piece : pieces_of(face)) nearest = std::min(nearest, distance_from(piece, x));
  if (dimension == 2 || face.normal.isZero()) return nearest;
  const Point3 inwards = face.normal.normalized();
  const double distance = inwards.dot(x - face.point);
  if (distance < 0.0 || (face.within && !contains(*face.within, x - distance * inwards, 3))) return nearest;
  return std::min(nearest, distance);
}

bool is_reservoir(const Case& scene, const WaterFace& face) {
  return (face.head || face.basin_area) && !is_inlet(scene, face);
}

std::optional<Crest> crest_of(const Case& scene, const WaterFace& face) {
  const auto& points = face.face.points;
  const double g = scene.general.gravity.norm();
  if (points.size() < 2 || g == 0.0) return std::nullopt;
  const Point3 up = -scene.general.gravity / g;
  const Point3 &a = points.front(), &b = points.back();
  // A level face has a crest unless walls or faces stand at both of its ends.
  const double slack = 1e-6 * (b - a).norm();
  const bool first = up.dot(a) > up.dot(b);
  const Point3& top = first ? a : b;
  const auto goes_on = [&](const Face& other, const Point3& end) {
    if (&other == &face.face) return false;
    if (other.points.empty()) return std::abs(other.normal.normalized().dot(end - other.point)) < slack;
    for (std::size_t i = 0; i + 1 < other.points.size(); ++i) {
      const Point3 s = other.points[i + 1] - other.points[i];
      const double along = std::clamp(s.dot(end - other.points[i]) / s.squaredNorm(), 0.0, 1.0);
      if ((other.points[i] + along * s - end).norm() >= slack) continue;
      // A floor that continues from that end and is no higher does not keep water back.
      const bool floor = up.dot(Point3(-s.y(), s.x(), 0.0)) > slack &&
                         std::max(up.dot(other.points[i]), up.dot(other.points[i + 1])) < up.dot(end) + slack;
      if (!floor) return true;
    }
    return false;
  };
  const auto held = [&](const Point3& end) {
    if (!scene.general.periodic.empty()) return true;
    for (const auto& wall : scene.walls)
      if (wall.water != Wall::ForWater::none && goes_on(wall.face, end)) return true;
    return std::any_of(scene.water_faces.begin(), scene.water_faces.end(),
                       [&](const WaterFace& other) { return goes_on(other.face, end); });
  };
  const bool level = std::abs(up.dot(a - b)) < slack;
  if (level ? held(a) && held(b) : held(top)) return std::nullopt;
  Crest crest{top, up.dot(top), Point3::Zero()};
  const Point3 along = first ? Point3(points[1] - points[0]) : Point3(points.back() - points[points.size() - 2]);
  const Point3 left(-along.y(), along.x(), 0.0), across = left - up.dot(left) * up;
  if (!level && across.norm() > 1e-6 * along.norm()) crest.inward = across.normalized();
  return crest;
}

bool is_behind(const Case& scene, const WaterFace& face, const Point3& x) {
  const auto& points = face.face.points;
  if (points.empty()) return face.face.normal.dot(x - face.face.point) < 0.0;
  double least = HUGE_VAL;
  Point3 nearest = Point3::Zero(), normal = Point3::Zero();
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Point3 s = points[i + 1] - points[i], left = Point3(-s.y(), s.x(), 0.0).normalized();
    const Point3 foot = points[i] + std::clamp(s.dot(x - points[i]) / s.squaredNorm(), 0.0, 1.0) * s;
    const double distance = (x - foot).norm();
    // At a corner both pieces are equally near: the sum of their normals is taken.
    if (distance < least * (1.0 - 1e-9))
      normal = left;
    else if (distance <= least * (1.0 + 1e-9))
      normal += left;
    if (distance < least) nearest = foot;
    least = std::min(least, distance);
  }
  const Point3 up = -scene.general.gravity.normalized();
  if ((nearest == points.front() || nearest == points.back()) && up.dot(x - nearest) > 0.0 &&
      up.dot(nearest) >= std::max(up.dot(points.front()), up.dot(points.back())))
    if (const Point3 across = normal - up.dot(normal) * up; across.norm() > 1e-6 * normal.norm()) normal = across;
  return normal.dot(x - nearest) < 0.0;
}

std::string no_way_over(const Case& scene, const Crest& crest) {
  if (crest.inward.isZero()) return "the face is level and open at an end, there is no crest";
  if (scene.coupled() && scene.can_yield())
    return "the soil can yield, and still water cannot follow a crest that slides";
  return {};
}

template <int D>
std::vector<sph::ImagePlane<D>> planes_of(const Face& face, int boundary, double margin) {
  std::vector<sph::ImagePlane<D>> planes;
  if (face.points.empty()) {
    if (face.normal.isZero()) return planes;  // a wall with a shape has no planes
    sph::ImagePlane<D> plane;
    plane.point = face.point.head<D>();
    plane.normal = face.normal.head<D>().normalized();
    plane.boundary = boundary;
    planes.push_back(plane);
    return planes;
  }
  if constexpr (D == 2) {
    for (std::size_t i = 0; i + 1 < face.points.size(); ++i) {
      const Vec<2> a = face.points[i].head<2>(), b = face.points[i + 1].head<2>();
      sph::ImagePlane<2> plane;
      plane.point = a;
      plane.tangent = (b - a).normalized();
      plane.normal = Vec<2>(-plane.tangent.y(), plane.tangent.x());
      plane.from = plane.tangent.dot(a) - margin;
      plane.to = plane.tangent.dot(b) + margin;
      plane.boundary = boundary;
      planes.push_back(plane);
    }
  }
  return planes;
}

template <int D>
void meet_at_corners(std::span<sph::ImagePlane<D>> planes, double margin) {
  // Behind corners of 120 degrees or more, images fill the space exactly once if the bisector divides them. Behind a
  // corner of 90 degrees images of images are needed. In between, the way with the smaller error is taken.
  constexpr double narrow = 0.26;  // cosine of the turn at 105 degrees
  // Pieces are walked with the domain on the left: the next piece begins where this one ends.
  std::vector<std::array<Vec<D>, 2>> corners;
  for (auto& plane : planes) {
    plane.piece = static_cast<int>(corners.size());
    corners.push_back({plane.point + (plane.from - plane.tangent.dot(plane.point)) * plane.tangent,
                       plane.point + (plane.to - plane.tangent.dot(plane.point)) * plane.tangent});
  }
  for (std::size_t i = 0; i < planes.size(); ++i) {
    auto& plane = planes[i];
    if (plane.tangent.isZero()) continue;
    std::array<double, 2> longer{margin, margin};
    for (std::size_t j = 0; j < planes.size(); ++j) {
      if (i == j || planes[j].tangent.isZero()) continue;
      for (const std::size_t e : {0, 1}) {
        const std::size_t across = 1 - e;
        if ((corners[i][e] - corners[j][across]).norm() > 0.01 * margin) continue;
        const Vec<D> outward = e == 1 ? plane.tangent : Vec<D>(-plane.tangent);
        const Vec<D> onward = e == 1 ? planes[j].tangent : Vec<D>(-planes[j].tangent);
        const double towards = plane.normal.dot(onward);  // sine of the turn towards the domain
        if (towards > 0.01 && outward.dot(onward) < narrow) {
          plane.overhangs[e].closed_by = planes[j].piece;
          continue;
        }
        if (towards <= 0.01) longer[e] = 0.0;
        const Vec<D> bisector = (outward + onward).normalized();
        // Points on the bisector itself are images of the earlier piece.
        plane.ends[e] = {corners[i][e] + (e == 1 ? 1e-9 : -1e-9) * margin * bisector, bisector};
      }
    }
    for (const std::size_t e : {0, 1}) {
      auto& overhang = plane.overhangs[e];
      overhang.length = longer[e];
      const Vec<D> outward = e == 1 ? plane.tangent : Vec<D>(-plane.tangent);
      for (std::size_t j = 0; overhang.closed_by < 0 && j < planes.size(); ++j) {
        const bool on_it = planes[j].faces(corners[i][e]) &&
                           std::abs(planes[j].normal.dot(corners[i][e] - planes[j].point)) < 0.01 * margin;
        if (j != i && on_it && planes[j].normal.dot(outward) < -narrow) overhang.closed_by = planes[j].piece;
      }
    }
    plane.from -= longer[0];
    plane.to += longer[1];
  }
}

template <int D>
std::vector<sph::ImagePlane<D>> periodic_planes(const General& general, int boundary) {
  std::vector<sph::ImagePlane<D>> planes;
  for (const int axis : general.periodic) {
    const double length = general.domain_max[axis] - general.domain_min[axis];
    for (const double side : {1.0, -1.0}) {
      sph::ImagePlane<D> plane;
      plane.kind = sph::ImagePlane<D>::Kind::periodic;
      plane.point = (side > 0 ? general.domain_min : general.domain_max).template head<D>();
      plane.normal[axis] = side;
      plane.shift[axis] = side * length;
      plane.boundary = boundary;
      planes.push_back(plane);
    }
  }
  return planes;
}

template Lattice<2> fill<2>(const Shape&, double, const Point3&, double, unsigned, std::span<const Shape>);
template Lattice<3> fill<3>(const Shape&, double, const Point3&, double, unsigned, std::span<const Shape>);
template Lattice<2> lay<2>(const Shape&, double, const Point3&, double, unsigned, std::span<const Shape>);
template Lattice<3> lay<3>(const Shape&, double, const Point3&, double, unsigned, std::span<const Shape>);
template std::vector<sph::ImagePlane<2>> planes_of<2>(const Face&, int, double);
template std::vector<sph::ImagePlane<3>> planes_of<3>(const Face&, int, double);
template void meet_at_corners<2>(std::span<sph::ImagePlane<2>>, double);
template void meet_at_corners<3>(std::span<sph::ImagePlane<3>>, double);
template std::vector<sph::ImagePlane<2>> periodic_planes<2>(const General&, int);
template std::vector<sph::ImagePlane<3>> periodic_planes<3>(const General&, int);

}  // namespace poretwin
