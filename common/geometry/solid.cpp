#include "common/geometry/solid.hpp"

#include "common/core/error.hpp"
#include "common/geometry/mesh_file.hpp"
#include "common/geometry/pieces.hpp"

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>

namespace poretwin {
namespace {

constexpr double pi = std::numbers::pi;

/// Largest distance of a facet from the curved surface that it stands for, in spacings. Test: Solids.*.
constexpr double sag = 1e-2;

/// Number of sides of a regular polygon that stands for a circle.
Index sides_for(double radius, double spacing) {
  return static_cast<Index>(std::clamp(std::ceil(pi / std::sqrt(2.0 * sag * spacing / radius)), 24.0, 2048.0));
}

Triangles box(const Point3& a, const Point3& b) {
  Triangles mesh;
  for (const double z : {a.z(), b.z()})
    for (const double y : {a.y(), b.y()})
      for (const double x : {a.x(), b.x()}) mesh.points.emplace_back(x, y, z);
  mesh.facets = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                 {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// An icosahedron whose facets are divided until they are close to the ball.
Triangles ball(const Point3& centre, double radius, double spacing) {
  const double g = std::numbers::phi;
  Triangles mesh;
  for (const double s : {-1.0, 1.0})
    for (const double t : {-g, g}) {
      mesh.points.emplace_back(0.0, s, t);
      mesh.points.emplace_back(s, t, 0.0);
      mesh.points.emplace_back(t, 0.0, s);
    }
  for (auto& x : mesh.points) x.normalize();
  // All triples of neighbouring corners, ordered so that normals point outwards.
  const double edge = 1.1 * (mesh.points[0] - mesh.points[6]).norm();
  const auto near = [&](Index i, Index j) { return (mesh.points[i] - mesh.points[j]).norm() < edge; };
  for (Index i = 0; i < 12; ++i)
    for (Index j = i + 1; j < 12; ++j)
      for (Index k = j + 1; k < 12; ++k)
        if (near(i, j) && near(j, k) && near(k, i)) {
          const bool out = mesh.points[i].dot(mesh.points[j].cross(mesh.points[k])) > 0.0;
          mesh.facets.push_back(out ? Facet{i, j, k} : Facet{i, k, j});
        }
  constexpr int most_divisions = 7;
  double length = edge * radius;
  for (int n = 0; n < most_divisions && length * length / (6.0 * radius) > sag * spacing; ++n, length *= 0.5) {
    std::map<std::pair<Index, Index>, Index> middles;
    const auto middle = [&](Index i, Index j) {
      const auto [found, fresh] = middles.try_emplace(std::minmax(i, j), static_cast<Index>(mesh.points.size()));
      if (fresh) mesh.points.push_back((mesh.points[i] + mesh.points[j]).normalized());
      return found->second;
    };
    std::vector<Facet> finer;
    for (const auto& [a, b, c] : mesh.facets) {
      const Index ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.facets = std::move(finer);
  }
  const double volume = TriangleMesh(mesh).volume(), scale = radius * std::cbrt(4.0 / 3.0 * pi / volume);
  for (auto& x : mesh.points) x = centre + scale * x;
  return mesh;
}

/// Triangles of a polygon in the plane, counter-clockwise, by cutting off ears.
std::vector<Facet> triangles_of(const std::vector<Point3>& p) {
  std::vector<Index> left(p.size());
  for (Index i = 0; i < p.size(); ++i) left[i] = i;
  std::vector<Facet> result;
  const auto is_ear = [&](std::size_t k, bool flat) {
    const std::size_t n = left.size();
    const Point3 &a = p[left[(k + n - 1) % n]], &b = p[left[k]], &c = p[left[(k + 1) % n]];
    const double area = cross(b - a, c - b);
    if (flat ? area < 0.0 : area <= 0.0) return false;
    return std::none_of(left.begin(), left.end(), [&](Index i) {
      const Point3& x = p[i];
      if (x == a || x == b || x == c) return false;
      return cross(b - a, x - a) >= 0.0 && cross(c - b, x - b) >= 0.0 && cross(a - c, x - c) >= 0.0;
    });
  };
  while (left.size() >= 3) {
    const std::size_t n = left.size();
    std::size_t ear = n;
    for (const bool flat : {false, true})
      for (std::size_t k = 0; k < n && ear == n; ++k)
        if (is_ear(k, flat)) ear = k;
    if (ear == n)
      throw CaseError("the polygon cannot be cut into triangles; expected a line that does not touch itself");
    const Facet f{left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]};
    result.push_back(f);
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  return result;
}

std::vector<Point3> counter_clockwise(std::vector<Point3> p) {
  double twice = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) twice += cross(p[i] - p[0], p[(i + 1) % p.size()] - p[0]);
  if (twice < 0.0) std::reverse(p.begin(), p.end());
  return p;
}

Triangles extrusion(const Shape& s) {
  const auto section = counter_clockwise(s.points);
  const auto n = static_cast<Index>(section.size());
  const int axis = s.along[0];
  // The section's coordinates are those along the other two axes, in their order.
  const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
  Triangles mesh;
  for (const double end : {s.from, s.to})
    for (const auto& x : section) {
      Point3 point;
      point[axis] = end;
      point[u] = x.x();
      point[v] = x.y();
      mesh.points.push_back(point);
    }
  for (const auto& [a, b, c] : triangles_of(section)) {
    mesh.facets.push_back({a, c, b});
    mesh.facets.push_back({a + n, b + n, c + n});
  }
  for (Index i = 0; i < n; ++i) {
    const Index j = (i + 1) % n;
    mesh.facets.push_back({i, j, j + n});
    mesh.facets.push_back({i, j + n, i + n});
  }
  return mesh;
}

/// A section revolved about an axis. Coordinates of its points: distance from the axis, and place along the axis.
/// Circles become polygons of the same area, so that the volume is right.
Triangles revolution(const std::vector<Point3>& points, const Point3& foot, const Point3& axis, double spacing) {
  const auto section = counter_clockwise(points);
  double widest = 0.0;
  for (const auto& x : section) widest = std::max(widest, x.x());
  const Index sides = sides_for(widest, spacing), n = static_cast<Index>(section.size());
  const double step = 2.0 * pi / sides, wider = std::sqrt(step / std::sin(step));
  const Point3 u = axis.unitOrthogonal(), v = axis.cross(u);
  Triangles mesh;
  for (Index k = 0; k < sides; ++k)
    for (const auto& x : section)
      mesh.points.push_back(foot + x.y() * axis + wider * x.x() * (std::cos(k * step) * u + std::sin(k * step) * v));
  for (Index k = 0; k < sides; ++k)
    for (Index i = 0; i < n; ++i) {
      const Index j = (i + 1) % n, a = k * n, b = (k + 1) % sides * n;
      // Points on the axis are not repeated around it.
      const Index ai = a + i, aj = a + j, bi = section[i].x() == 0.0 ? ai : b + i,
                  bj = section[j].x() == 0.0 ? aj : b + j;
      if (bi != ai) mesh.facets.push_back({ai, bi, bj});
      if (bj != aj) mesh.facets.push_back({ai, bj, aj});
    }
  return mesh;
}

Triangles frustum(const Shape& s, double spacing) {
  const Point3 way = s.ends[1] - s.ends[0];
  const double length = way.norm(), end = s.kind == Shape::Kind::cone ? s.end_radius : s.radius;
  std::vector<Point3> section{{0.0, 0.0, 0.0}, {s.radius, 0.0, 0.0}, {end, length, 0.0}, {0.0, length, 0.0}};
  if (end == 0.0) section.erase(section.begin() + 2);
  if (s.radius == 0.0) section.erase(section.begin() + 1);
  return revolution(section, s.ends[0], way / length, spacing);
}

Triangles drawn(const Shape& s, double spacing, const std::function<std::string(const std::string&)>& read) {
  const std::string ending = std::filesystem::path(s.file).extension().string();
  switch (s.kind) {
    case Shape::Kind::box:
      return box(s.min, s.max);
    case Shape::Kind::ball:
      return ball(s.centre, s.radius, spacing);
    case Shape::Kind::cylinder:
    case Shape::Kind::cone:
      return frustum(s, spacing);
    case Shape::Kind::polygon:
      return s.around.empty() ? extrusion(s) : revolution(s.points, s.centre, Point3::Unit(s.around[0]), spacing);
    case Shape::Kind::mesh:
      return parse_mesh(read(s.file), ending);
    case Shape::Kind::terrain:
      return parse_terrain(read(s.file), ending, s.bottom);
  }
  return {};
}

}  // namespace

Point3 placed(const Placement& placement, const Point3& x, int dimension) {
  const Point3 axis = dimension == 3 ? placement.axis.normalized() : Point3::UnitZ();
  return Eigen::AngleAxisd(placement.turn * pi / 180.0, axis) * (placement.scale * x) + placement.move;
}

Triangles surface_of(const Shape& shape, double spacing, const std::function<std::string(const std::string&)>& read) {
  Triangles mesh = joined(drawn(shape, spacing, read));
  if (shape.placement)
    for (auto& x : mesh.points) x = placed(*shape.placement, x, 3);
  return TriangleMesh(mesh).volume() < 0.0 ? turned_round(std::move(mesh)) : mesh;
}

Solid::Solid(std::vector<Part> parts, double resolution) : parts_(std::move(parts)), resolution_(resolution) {
  bounds_ = parts_[0].mesh.bounds();
  for (const auto& part : parts_) {
    if (part.cut_out) continue;
    const auto [lower, upper] = part.mesh.bounds();
    bounds_.first = bounds_.first.cwiseMax(lower);
    bounds_.second = bounds_.second.cwiseMin(upper).cwiseMax(bounds_.first);
  }
  volume_ = parts_[0].mesh.volume();
  if (parts_.size() == 1) return;
  // The volume is summed over cubes. Cubes that the body's surface crosses are divided into eight. A fraction of each
  // of these counts, as if the surface were a plane at the distance that it has from the cube's centre.
  constexpr double most_cells = 5e4;
  const Point3 size = bounds_.second - bounds_.first;
  const double cell = std::max(resolution_, std::cbrt(size.prod() / most_cells));
  const Eigen::Array3d count = (size / cell).array().ceil();
  const Point3 first = 0.5 * (bounds_.first + bounds_.second) - 0.5 * cell * (count - 1.0).matrix();
  const auto share = [&](auto&& self, const Point3& x, double half, int divisions) -> double {
    const double away = depth(x, 2.0 * half) / half;
    if (std::abs(away) >= std::sqrt(3.0)) return away > 0.0 ? 1.0 : 0.0;
    if (divisions == 0) return std::clamp(0.5 + 0.5 * away, 0.0, 1.0);
    double sum = 0.0;
    for (const double i : {-0.5, 0.5})
      for (const double j : {-0.5, 0.5})
        for (const double k : {-0.5, 0.5})
          sum += 0.125 * self(self, x + half * Point3(i, j, k), 0.5 * half, divisions - 1);
    return sum;
  };
  double cells = 0.0;
  for (double k = 0; k < count[2]; ++k)
    for (double j = 0; j < count[1]; ++j)
      for (double i = 0; i < count[0]; ++i) cells += share(share, first + cell * Point3(i, j, k), 0.5 * cell, 1);
  volume_ = cells * cell * cell * cell;
}

bool Solid::contains(const Point3& x) const {
  if (((x - bounds_.first).array() < 0.0).any() || ((bounds_.second - x).array() < 0.0).any()) return false;
  return std::all_of(parts_.begin(), parts_.end(), [&](const Part& part) { return part.contains(x); });
}

double Solid::depth(const Point3& x, double range) const {
  double least = range;
  for (const auto& part : parts_) least = std::min(least, part.depth(x, range));
  return least;
}

std::pair<double, double> Solid::extent(const Point3& direction) const {
  // Where the solid has several parts, only corners of facets on the body itself count. The corners at which the
  // surfaces of two parts cut each other are not among them, so that the result may be a little too small.
  double lowest = HUGE_VAL, highest = -HUGE_VAL;
  const double slack = 1e-6 * (bounds_.second - bounds_.first).norm();
  for (const auto& part : parts_)
    for (const auto& x : part.mesh.triangles().points) {
      if (parts_.size() > 1 && depth(x, 2.0 * slack) < -slack) continue;
      lowest = std::min(lowest, direction.dot(x));
      highest = std::max(highest, direction.dot(x));
    }
  return {lowest, highest};
}

Solid Solid::moved(const Point3& way) const {
  std::vector<Part> parts;
  for (const auto& part : parts_) {
    Triangles mesh = part.mesh.triangles();
    for (auto& x : mesh.points) x += way;
    parts.push_back({TriangleMesh(std::move(mesh)), part.cut_out});
  }
  return {std::move(parts), resolution_};
}

}  // namespace poretwin
