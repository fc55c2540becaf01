#include "common/geometry/surfaces.hpp"

#include "common/core/threads.hpp"
#include "common/particles/neighbours.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace poretwin {
namespace {

/// Cosine of 45 degrees: two wall points belong to two walls if their normals differ by at least this angle. On a
/// curved wall smaller angles occur within one wall.
constexpr double one_wall = 0.7;
/// A facet's nearest point acts as a mirror for a particle only where the direction from that point to the particle has
/// at least this cosine with the facet's normal. At an edge that turns away from the domain no facet does.
constexpr double faces = 0.9;
/// Cosine of the angle between the normals in a corner of 105 degrees. Behind wider corners the images by single walls
/// fill the space. Behind narrower ones the images by both walls together are needed, too.
constexpr double wide_corner = 0.26;
/// An image is dropped if its distance from another wall is below this fraction of its distance from the mirror.
constexpr double cut_off = 0.98;
/// A wall's curvature is fitted to the wall points within this fraction of the range of images, some two spacings,
/// several facets. Test (value untried): SoilInShapedWalls.IsNotStrainedWhereItTurnsInACylinder.
constexpr double bend_reach = 0.75;
/// Largest ratio of distance to radius of curvature up to which images are stretched in proportion: the ratio of the
/// kernel's reach to a radius of five spacings.
constexpr double most_bent = 0.5;
/// Weight on the curvature, over the sum of squared distances. Small, since the curvature is too low by this fraction.
constexpr double bend_damping = 1e-3;
/// Allowance for rounding errors, relative to the distances that are compared.
constexpr double slack = 1e-6;

/// Sign with which the outward normals of a part point into the domain.
double into_domain(bool domain_inside, const Solid::Part& part) { return domain_inside == part.cut_out ? 1.0 : -1.0; }

Vec<3> mirrored(const Vec<3>& x, const Surfaces::WallPoint& wall) {
  return x - 2.0 * wall.normal.dot(x - wall.at) * wall.normal;
}

}  // namespace

Mat<3> Surfaces::WallPoint::stretch() const {
  if (bend.isZero(0.0)) return Mat<3>::Identity();
  Eigen::SelfAdjointEigenSolver<Mat<3>> solver;
  solver.computeDirect(bend);
  const Eigen::Array3d bent = (distance * solver.eigenvalues()).array().max(-most_bent).min(most_bent);
  const Mat<3>& axes = solver.eigenvectors();
  return axes * ((1.0 - bent) / (1.0 + bent)).matrix().asDiagonal() * axes.transpose();
}

void Surfaces::add(const Wall& wall, int boundary) {
  if (wall.shape)
    add(wall.shape->solid, wall.domain == Wall::Domain::inside, boundary);
  else
    add(wall.face.point, wall.face.normal.normalized(), boundary);
}

void Surfaces::add(std::shared_ptr<const Solid> solid, bool domain_inside, int boundary) {
  bodies_.push_back({std::move(solid), domain_inside, boundary});
}

void Surfaces::add(const Vec<3>& point, const Vec<3>& normal, int boundary) {
  planes_.push_back({point, normal, boundary});
}

bool Surfaces::is_covered(const Vec<3>& at, const Body* body, const Solid::Part* part, const Plane* plane) const {
  for (const auto& p : planes_)
    if (&p != plane && p.normal.dot(at - p.point) < 0.0) return true;
  for (const auto& other : bodies_)
    if (&other != body && other.solid->contains(at) != other.domain_inside) return true;
  if (body)
    for (const auto& other : body->solid->parts())
      if (&other != part && !other.contains(at)) return true;
  return false;
}

Surfaces::WallPoints Surfaces::walls_near(const Vec<3>& x, double range) const {
  static const double one_wall_angle = std::acos(one_wall);
  WallPoints found;
  // Whether a wall point has another direction (normal) than those found so far and lies behind none of them.
  const auto another = [&](const Vec<3>& normal, const Vec<3>& at) {
    return std::ranges::none_of(found.all(), [&](const WallPoint& w) {
      return normal.dot(w.normal) >= one_wall || w.normal.dot(at - w.at) < -slack * range;
    });
  };
  while (found.size < found.point.size()) {
    WallPoint nearest;
    nearest.distance = range;
    for (const auto& plane : planes_) {
      const double distance = plane.normal.dot(x - plane.point);
      const Vec<3> at = x - distance * plane.normal;
      if (distance <= 0.0 || distance >= nearest.distance || !another(plane.normal, at)) continue;
      if (!is_covered(at + slack * range * plane.normal, nullptr, nullptr, &plane))
        nearest = {at, plane.normal, distance, plane.boundary};
    }
    for (const auto& body : bodies_)
      for (const auto& part : body.solid->parts()) {
        const double side = into_domain(body.domain_inside, part);
        const auto met = part.mesh.nearest_if(
            x, nearest.distance,
            [&](const Vec<3>& direction, double spread) {
              return std::ranges::any_of(found.all(), [&](const WallPoint& w) {
                const double angle = std::acos(std::clamp(side * direction.dot(w.normal), -1.0, 1.0));
                return angle + std::acos(std::clamp(spread, -1.0, 1.0)) < one_wall_angle;
              });
            },
            [&](const TriangleMesh::Nearest& near) {
              const Vec<3> n = side * part.mesh.normal(near.facet), away = x - near.point;
              return n.dot(away) > 0.0 && n.dot(away) >= faces * near.distance && another(n, near.point) &&
                     !is_covered(near.point + slack * range / near.distance * away, &body, &part, nullptr);
            });
        if (met && met->distance < nearest.distance)
          nearest = {met->point, (x - met->point) / met->distance, met->distance, body.boundary};
      }
    if (!(nearest.distance < range)) break;
    found.point[found.size++] = nearest;
  }
  return found;
}

std::optional<Surfaces::Hit> Surfaces::first_hit(const Vec<3>& from, const Vec<3>& to) const {
  std::optional<Hit> first;
  for (const auto& plane : planes_) {
    const double inside = plane.normal.dot(from - plane.point), outside = plane.normal.dot(plane.point - to);
    if (outside <= 0.0) continue;
    const double along = std::max(0.0, inside) / std::max(inside + outside, 1e-300);
    if (!first || along < first->along) first = Hit{along, plane.normal};
  }
  for (const auto& body : bodies_)
    for (const auto& part : body.solid->parts()) {
      const auto along = part.mesh.crossing(from, to);
      if (!along || (first && *along >= first->along)) continue;
      const Vec<3> at = from + *along * (to - from);
      const auto facet = part.mesh.nearest(at, HUGE_VAL)->facet;
      const Vec<3> n = into_domain(body.domain_inside, part) * part.mesh.normal(facet);
      if (n.dot(to - from) < 0.0 && !is_covered(at + slack * (to - from).norm() * n, &body, &part, nullptr))
        first = Hit{*along, n};
    }
  return first;
}

bool Surfaces::is_cut_off(const Vec<3>& from, const Vec<3>& image, double distance) const {
  const auto hides = [&](const Vec<3>& wall) {
    const Vec<3> before = wall + 1e-3 * (from - wall);
    return holds(before) && !first_hit(from, before);
  };
  for (const auto& plane : planes_) {
    const double away = plane.normal.dot(image - plane.point);
    if (std::abs(away) < cut_off * distance && hides(image - away * plane.normal)) return true;
  }
  bool found = false;
  for (const auto& body : bodies_)
    for (const auto& part : body.solid->parts())
      part.mesh.for_each_near(image, cut_off * distance, [&](const TriangleMesh::Nearest& near) {
        found = found || (near.distance < cut_off * distance && hides(near.point));
      });
  return found;
}

// Fits the normal n and its derivative S along the wall (symmetric, tangential) by least squares: n + S (x_j - x) comes
// as close as possible to the normals n_j of the wall points x_j within the range. A small weight on S makes it unique
// in directions without other points. On flat walls nothing changes.
void Surfaces::find_bends(double range, std::vector<Found>& found) {
  std::vector<WallPoint*> points;
  for (auto& some : found)
    for (auto& [who, walls] : some)
      for (std::size_t k = 0; k < walls.size; ++k) points.push_back(&walls.point[k]);
  VecArray<3> at, normal;
  for (const auto* point : points) {
    at.push_back(point->at);
    normal.push_back(point->normal);
  }
  if (at.empty()) return;
  sph::CellGrid<3> grid;
  grid.build(at, range);
  parallel_for(points.size(), [&](std::size_t k) {
    using Unknowns = Eigen::Matrix<double, 5, 1>;
    const Vec<3>& n = normal[k];
    const Vec<3> u = n.unitOrthogonal(), v = n.cross(u);
    Eigen::Matrix<double, 5, 5> moment = Eigen::Matrix<double, 5, 5>::Zero();
    Unknowns right = Unknowns::Zero();
    double spread = 0.0;
    grid.for_each_within(at[k], range, [&](Index j, double r2) {
      if (points[j]->boundary != points[k]->boundary || normal[j].dot(n) < faces) return;
      const Vec<3> way = at[j] - at[k], change = normal[j] - n;
      const double weight = 1.0 - r2 / (range * range), a = way.dot(u), b = way.dot(v);
      // Factors of S_uu, S_uv, S_vv, and of the change of the normal itself along u and v.
      const Unknowns along_u(Unknowns{{a, b, 0.0, 1.0, 0.0}}), along_v(Unknowns{{0.0, a, b, 0.0, 1.0}});
      moment += weight * (along_u * along_u.transpose() + along_v * along_v.transpose());
      right += weight * (change.dot(u) * along_u + change.dot(v) * along_v);
      spread += weight * r2;
    });
    if (right.norm() <= slack * spread / range) return;  // flat
    moment.diagonal().head<3>().array() += bend_damping * spread;
    const Unknowns s = moment.ldlt().solve(right);
    points[k]->bend =
        s[0] * u * u.transpose() + s[1] * (u * v.transpose() + v * u.transpose()) + s[2] * v * v.transpose();
    points[k]->normal = (n + s[3] * u + s[4] * v).normalized();
  });
}

sph::Images<3> Surfaces::images(std::span<const Vec<3>> points, double range, std::vector<WallPoints>* mirrors) const {
  const std::size_t parts = std::max<std::size_t>(1, points.size() / 1024);
  std::vector<Found> found(parts);
  for_each_part(parts, [&](std::size_t part) {
    for (std::size_t b = points.size() * part / parts; b < points.size() * (part + 1) / parts; ++b)
      if (const auto walls = walls_near(points[b], range); walls.size > 0)
        found[part].emplace_back(static_cast<Index>(b), walls);
  });
  if (mirrors) find_bends(bend_reach * range, found);
  std::vector<sph::Images<3>> made(parts);
  std::vector<std::vector<WallPoints>> by(parts);
  for_each_part(parts, [&](std::size_t part) {
    auto& images = made[part];
    for (const auto& [b, walls] : found[part])
      for (unsigned set = 1; set < 1u << walls.size; ++set) {
        Vec<3> y = points[b];
        Mat<3> map = Mat<3>::Identity();
        std::uint32_t boundaries = 0;
        WallPoints passed;
        bool narrow = true;
        for (std::size_t i = 0; i < walls.size; ++i) {
          if ((set >> i & 1u) == 0) continue;
          const auto& wall = walls.point[i];
          for (std::size_t j = 0; j < i; ++j)
            narrow = narrow && ((set >> j & 1u) == 0 || wall.normal.dot(walls.point[j].normal) < wide_corner);
          y = mirrored(y, wall);
          map -= 2.0 * wall.normal * (wall.normal.transpose() * map).eval();
          boundaries |= 1u << wall.boundary;
          passed.point[passed.size++] = wall;
        }
        if (!narrow || (passed.size > 1 && holds(y)) || is_cut_off(points[b], y, 0.5 * (points[b] - y).norm()))
          continue;
        images.position.push_back(y);
        images.parent.push_back(b);
        images.map.push_back(map);
        images.carried.push_back(Vec<3>::Zero());
        images.boundaries.push_back(boundaries);
        if (mirrors) by[part].push_back(passed);
      }
  });
  const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  if (mirrors) {
    mirrors->clear();
    for (const auto& some : by) append(*mirrors, some);
  }
  sph::Images<3> all = std::move(made[0]);
  for (std::size_t part = 1; part < parts; ++part) {
    append(all.position, made[part].position);
    append(all.parent, made[part].parent);
    append(all.map, made[part].map);
    append(all.carried, made[part].carried);
    append(all.boundaries, made[part].boundaries);
  }
  return all;
}

bool Surfaces::come_near(const Vec<3>& x, double range) const {
  return std::ranges::any_of(planes_, [&](const Plane& p) { return std::abs(p.normal.dot(x - p.point)) < range; }) ||
         std::ranges::any_of(bodies_, [&](const Body& body) {
           return std::ranges::any_of(body.solid->parts(),
                                      [&](const Solid::Part& part) { return part.mesh.nearest(x, range).has_value(); });
         });
}

bool Surfaces::holds(const Vec<3>& x) const {
  return std::all_of(planes_.begin(), planes_.end(),
                     [&](const Plane& p) { return p.normal.dot(x - p.point) >= 0.0; }) &&
         std::all_of(bodies_.begin(), bodies_.end(),
                     [&](const Body& b) { return b.solid->contains(x) == b.domain_inside; });
}

void Surfaces::keep_inside(const Vec<3>& before, double reach, Vec<3>& x, Vec<3>& v) const {
  constexpr int most_walls = 6;
  Vec<3> from = before;
  bool thrown = false;
  for (int k = 0; k < most_walls; ++k) {
    const auto hit = first_hit(from, x);
    if (!hit) break;
    thrown = true;
    const Vec<3> at = from + hit->along * (x - from), past = x - at;
    from = at + slack * (x - from).norm() * hit->normal;
    const double through = -hit->normal.dot(past);
    x = from + past + (std::min(through, reach) + through) * hit->normal;
    v -= std::min(0.0, hit->normal.dot(v)) * hit->normal;
  }
  // In a sharp corner, where walls reflect the point back and forth, it returns to the position before its motion.
  if (!thrown || holds(x)) return;
  x = before;
  v.setZero();
}

std::optional<BentPlace> bent_place(const Shape& shape, Wall::Domain domain, double spacing,
                                    const std::function<bool(const Point3&)>& in_reach) {
  constexpr double most_samples = 100.0;
  constexpr double degrees = 180.0 / std::numbers::pi;
  constexpr double corner = 45.0;    // degrees: beyond this angle two facets are two walls (one_wall)
  constexpr double smallest = 1e-3;  // radians; smaller turns are rounding
  const bool inside = domain == Wall::Domain::inside;
  const auto& parts = shape.solid->parts();
  for (const auto& part : parts) {
    const auto& [points, facets] = part.mesh.triangles();
    struct Side {
      Index facet, opposite;  // the facet, and its corner that is not on the edge
    };
    std::map<std::pair<Index, Index>, Side> first;
    for (Index f = 0; f < facets.size(); ++f)
      for (std::size_t c = 0; c < 3; ++c) {
        const Index i = facets[f][c], j = facets[f][(c + 1) % 3], opposite = facets[f][(c + 2) % 3];
        const auto [found, is_new] = first.try_emplace(std::minmax(i, j), Side{f, opposite});
        if (is_new) continue;
        const Side other = found->second;
        const double side = into_domain(inside, part);
        const Point3 &a = points[i], &b = points[j];
        const Point3 n = side * part.mesh.normal(f), m = side * part.mesh.normal(other.facet);
        const double turn = std::atan2(n.cross(m).norm(), n.dot(m));
        if (turn < smallest) continue;
        Point3 at = Point3::Zero();
        bool counts = false;
        const int samples = static_cast<int>(std::clamp((b - a).norm() / spacing, 1.0, most_samples));
        for (int k = 0; k < samples && !counts; ++k) {
          at = a + (k + 0.5) / samples * (b - a);
          // Parts of the surface that other parts of the shape cut away do not count.
          counts = in_reach(at) && (parts.size() == 1 || shape.solid->depth(at, spacing) > -1e-3 * spacing);
        }
        if (!counts) continue;
        const bool away = n.dot(points[other.opposite] - a) < 0.0;
        if (away && turn * degrees > most_turned_away) return BentPlace{at, turn * degrees, 0.0};
        if (turn * degrees > corner) continue;
        // The distance between the places for which the facets' normals are right: their circumcentres, or, where these
        // lie close to the edge, their centroids.
        const Point3& tip = points[opposite];
        const Point3& other_tip = points[other.opposite];
        const auto cotangent = [&](const Point3& x) { return (a - x).dot(b - x) / (a - x).cross(b - x).norm(); };
        const auto height = [&](const Point3& x) { return (a - x).cross(b - x).norm() / (b - a).norm(); };
        const double width = std::max(0.5 * (b - a).norm() * (cotangent(tip) + cotangent(other_tip)),
                                      (height(tip) + height(other_tip)) / 3.0);
        if (width < least_radius * spacing * turn * (1.0 - 1e-2)) return BentPlace{at, 0.0, width / turn};
      }
  }
  return std::nullopt;
}

std::optional<ThinPlace> thin_place(const Shape& shape, Wall::Domain domain, double spacing) {
  // Two facets can be opposite sides of a wall only if the product of their normals is at most this value. Every body
  // is thin near the tip of a wedge, where the sides meet at an angle, and this does not count.
  constexpr double opposite = -0.8;
  constexpr double most_places = 1e5;
  const bool inside = domain == Wall::Domain::inside;
  const auto& parts = shape.solid->parts();
  for (const auto& part : parts) {
    const auto& [points, facets] = part.mesh.triangles();
    for (Index f = 0; f < facets.size(); ++f) {
      const Point3 &a = points[facets[f][0]], &b = points[facets[f][1]], &c = points[facets[f][2]];
      const Point3 into = -into_domain(inside, part) * part.mesh.normal(f);
      const double longest = std::max({(b - a).norm(), (c - a).norm(), (c - b).norm()});
      const int n = static_cast<int>(
          std::clamp(longest / spacing, 1.0, std::sqrt(most_places / static_cast<double>(facets.size())) + 1.0));
      for (int i = 0; i < n; ++i)
        for (int j = 0; i + j < n; ++j) {
          const Point3 at = a + (i + 1.0 / 3.0) / n * (b - a) + (j + 1.0 / 3.0) / n * (c - a);
          const Point3 from = at + 1e-3 * spacing * into, to = at + least_thickness * spacing * into;
          if (parts.size() > 1 && shape.solid->contains(at - 1e-3 * spacing * into) != inside) continue;
          for (const auto& other : parts) {
            const auto along = other.mesh.crossing(from, to);
            if (!along) continue;
            const Point3 out = from + *along * (to - from);
            const Point3 normal =
                -into_domain(inside, other) * other.mesh.normal(other.mesh.nearest(out, HUGE_VAL)->facet);
            if (normal.dot(into) < opposite) return ThinPlace{at, (out - at).norm()};
          }
        }
    }
  }
  return std::nullopt;
}

}  // namespace poretwin
