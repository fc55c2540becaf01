#include "common/geometry/triangle_mesh.hpp"

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

namespace poretwin {
namespace {

/// The point of a triangle that is nearest to x (Ericson 2005, 5.1.5).
Vec<3> nearest_on(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& x) {
  const Vec<3> ab = b - a, ac = c - a, ax = x - a, bx = x - b, cx = x - c;
  const double d1 = ab.dot(ax), d2 = ac.dot(ax), d3 = ab.dot(bx), d4 = ac.dot(bx), d5 = ab.dot(cx), d6 = ac.dot(cx);
  if (d1 <= 0.0 && d2 <= 0.0) return a;
  if (d3 >= 0.0 && d4 <= d3) return b;
  if (d6 >= 0.0 && d5 <= d6) return c;
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return a + d1 / (d1 - d3) * ab;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return a + d2 / (d2 - d6) * ac;
  if (va <= 0.0 && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const double sum = va + vb + vc;
  return sum > 0.0 ? Vec<3>(a + vb / sum * ab + vc / sum * ac) : a;
}

/// Solid angle of a triangle seen from x (van Oosterom & Strackee 1983).
double solid_angle(Vec<3> a, Vec<3> b, Vec<3> c, const Vec<3>& x) {
  a -= x;
  b -= x;
  c -= x;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  return 2.0 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
}

/// Where the line from o along d crosses a triangle, as a multiple of d (Moeller & Trumbore 1997).
std::optional<double> meeting(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& o, const Vec<3>& d) {
  const Vec<3> ab = b - a, ac = c - a, p = d.cross(ac), t = o - a, q = t.cross(ab);
  const double det = ab.dot(p);
  if (det == 0.0) return std::nullopt;
  const double u = t.dot(p) / det, v = d.dot(q) / det;
  constexpr double slack = 1e-9;  // so that no line passes between two adjacent triangles
  if (u < -slack || v < -slack || u + v > 1.0 + slack) return std::nullopt;
  return ac.dot(q) / det;
}

}  // namespace

TriangleMesh::TriangleMesh(Triangles triangles) : triangles_(std::move(triangles)) {
  facets_.resize(triangles_.facets.size());
  std::iota(facets_.begin(), facets_.end(), Index{0});
  for (const Index f : facets_) {
    const Vec<3> twice = (corner(f, 1) - corner(f, 0)).cross(corner(f, 2) - corner(f, 0));
    normals_.push_back(twice.normalized());
  }
  build(0, static_cast<Index>(facets_.size()));
  // Positions are taken relative to the centre: far from the origin, the sum would lose its digits.
  const Vec<3> o = nodes_[0].centre;
  for (const Index f : facets_) volume_ += (corner(f, 0) - o).dot((corner(f, 1) - o).cross(corner(f, 2) - o)) / 6.0;
}

void TriangleMesh::build(Index first, Index count) {
  constexpr Index most_in_leaf = 4;
  const std::size_t here = nodes_.size();
  Node node;
  node.first = first;
  node.count = count;
  node.lower = Vec<3>::Constant(HUGE_VAL);
  node.upper = -node.lower;
  node.centre = node.area = Vec<3>::Zero();
  double whole = 0.0;
  for (Index k = first; k < first + count; ++k) {
    const Vec<3>&a = corner(facets_[k], 0), &b = corner(facets_[k], 1), &c = corner(facets_[k], 2);
    const Vec<3> area = 0.5 * (b - a).cross(c - a);
    node.lower = node.lower.cwiseMin(a).cwiseMin(b).cwiseMin(c);
    node.upper = node.upper.cwiseMax(a).cwiseMax(b).cwiseMax(c);
    node.area += area;
    node.centre += area.norm() * (a + b + c) / 3.0;
    whole += area.norm();
  }
  node.direction = node.area.normalized();
  node.centre = whole > 0.0 ? Vec<3>(node.centre / whole) : Vec<3>(0.5 * (node.lower + node.upper));
  for (Index k = first; k < first + count; ++k)
    for (std::size_t c = 0; c < 3; ++c)
      node.radius = std::max(node.radius, (corner(facets_[k], c) - node.centre).norm());
  node.spread = 1.0;
  for (Index k = first; k < first + count; ++k)
    node.spread = std::min(node.spread, node.direction.dot(normals_[facets_[k]]));
  nodes_.push_back(node);
  if (count <= most_in_leaf) return;
  Eigen::Index axis = 0;
  (node.upper - node.lower).maxCoeff(&axis);
  const auto middle = [&](Index f) { return corner(f, 0)[axis] + corner(f, 1)[axis] + corner(f, 2)[axis]; };
  const Index half = count / 2;
  std::nth_element(facets_.begin() + first, facets_.begin() + first + half, facets_.begin() + first + count,
                   [&](Index f, Index g) { return std::pair(middle(f), f) < std::pair(middle(g), g); });
  build(first, half);
  nodes_[here].right = static_cast<Index>(nodes_.size());
  build(first + half, count - half);
}

/// Visits a tree of facets: enter(node) decides whether to go below a node, visit(facet) gets the facets of its leaves.
template <class Visit, class Enter>
void TriangleMesh::walk(const Enter& enter, const Visit& visit) const {
  std::array<Index, 64> stack;
  std::size_t depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const Index n = stack[--depth];
    const Node& node = nodes_[n];
    if (!enter(node)) continue;
    if (node.right == 0) {
      for (Index k = node.first; k < node.first + node.count; ++k) visit(facets_[k]);
      continue;
    }
    stack[depth++] = node.right;
    stack[depth++] = n + 1;
  }
}

double TriangleMesh::winding_number(const Vec<3>& x) const {
  // A part farther away than twice its size counts as a dipole; the error of the sum is then 1e-2 of a full turn.
  constexpr double far = 2.0;
  double angle = 0.0;
  walk(
      [&](const Node& node) {
        const Vec<3> way = node.centre - x;
        const double distance = way.norm();
        if (distance <= far * node.radius) return true;
        angle += node.area.dot(way) / (distance * distance * distance);
        return false;
      },
      [&](Index f) { angle += solid_angle(corner(f, 0), corner(f, 1), corner(f, 2), x); });
  return angle / (4.0 * std::numbers::pi);
}

bool TriangleMesh::contains(const Vec<3>& x) const {
  if (nodes_[0].distance2(x) > 0.0) return false;
  constexpr double straight = 1e-9;  // sine of the angle between the facet's normal and the line to the facet
  if (const auto near = nearest(x, HUGE_VAL); near && near->distance > 0.0) {
    const Vec<3> way = (x - near->point) / near->distance, outwards = normal(near->facet);
    if (way.cross(outwards).norm() < straight) return way.dot(outwards) < 0.0;
  }
  return winding_number(x) > 0.5;
}

Vec<3> TriangleMesh::nearest_on(Index facet, const Vec<3>& x) const {
  return poretwin::nearest_on(corner(facet, 0), corner(facet, 1), corner(facet, 2), x);
}

std::optional<TriangleMesh::Nearest> TriangleMesh::nearest(const Vec<3>& x, double range) const {
  return nearest_if(
      x, range, [](const Vec<3>&, double) { return false; }, [](const Nearest&) { return true; });
}

void TriangleMesh::for_each_near(const Vec<3>& x, double range,
                                 const std::function<void(const Nearest&)>& visit) const {
  walk([&](const Node& node) { return node.distance2(x) <= range * range; },
       [&](Index f) {
         const Vec<3> point = nearest_on(f, x);
         const double distance = (point - x).norm();
         if (distance <= range) visit({f, point, distance});
       });
}

void TriangleMesh::for_each_touching(const Vec<3>& lower, const Vec<3>& upper,
                                     const std::function<void(Index)>& visit) const {
  walk(
      [&](const Node& node) {
        return ((node.lower - upper).array() <= 0.0).all() && ((lower - node.upper).array() <= 0.0).all();
      },
      [&](Index f) {
        const Vec<3>&a = corner(f, 0), &b = corner(f, 1), &c = corner(f, 2);
        const Vec<3> low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
        if (((low - upper).array() <= 0.0).all() && ((lower - high).array() <= 0.0).all()) visit(f);
      });
}

std::optional<double> TriangleMesh::crossing(const Vec<3>& a, const Vec<3>& b) const {
  std::optional<double> first;
  const Vec<3> way = b - a;
  walk(
      [&](const Node& node) {
        double from = 0.0, to = first.value_or(1.0);
        for (int d = 0; d < 3; ++d) {
          if (way[d] == 0.0) {
            if (a[d] < node.lower[d] || a[d] > node.upper[d]) return false;
            continue;
          }
          const double one = (node.lower[d] - a[d]) / way[d], other = (node.upper[d] - a[d]) / way[d];
          from = std::max(from, std::min(one, other));
          to = std::min(to, std::max(one, other));
        }
        return from <= to * (1.0 + 1e-12) + 1e-12;
      },
      [&](Index f) {
        const auto at = meeting(corner(f, 0), corner(f, 1), corner(f, 2), a, way);
        if (at && *at >= 0.0 && *at <= first.value_or(1.0)) first = at;
      });
  return first;
}

double TriangleMesh::depth(const Vec<3>& x, double range) const {
  const auto found = nearest(x, range);
  if (!found) return contains(x) ? range : -range;
  // If the nearest point lies inside a facet, the facet's normal shows on which side x lies; at an edge or a corner it
  // may not.
  constexpr double over = 1.0 - 1e-9;
  const double away = normals_[found->facet].dot(x - found->point);
  if (std::abs(away) > over * found->distance) return -away;
  return contains(x) ? found->distance : -found->distance;
}

Triangles joined(const Triangles& triangles) {
  Triangles result;
  std::vector<Index> order(triangles.points.size()), now(order.size());
  std::iota(order.begin(), order.end(), Index{0});
  const auto row = [&](Index i) {
    return std::tuple(triangles.points[i].x(), triangles.points[i].y(), triangles.points[i].z());
  };
  std::sort(order.begin(), order.end(), [&](Index i, Index j) { return std::pair(row(i), i) < std::pair(row(j), j); });
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (k == 0 || row(order[k]) != row(order[k - 1])) result.points.push_back(triangles.points[order[k]]);
    now[order[k]] = static_cast<Index>(result.points.size() - 1);
  }
  for (const auto& f : triangles.facets) {
    const Facet g{now[f[0]], now[f[1]], now[f[2]]};
    if (g[0] != g[1] && g[1] != g[2] && g[2] != g[0]) result.facets.push_back(g);
  }
  return result;
}

Triangles turned_round(Triangles triangles) {
  for (auto& f : triangles.facets) std::swap(f[1], f[2]);
  return triangles;
}

namespace {

/// Where an edge of one triangle passes through the inside of the other, away from the borders of both.
std::optional<Vec<3>> crossing_of(const std::array<Vec<3>, 3>& t, const std::array<Vec<3>, 3>& u) {
  constexpr double inside = 1e-6;
  for (const auto& [edges, face] : {std::pair{&t, &u}, {&u, &t}})
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec<3>&o = (*edges)[c], d = (*edges)[(c + 1) % 3] - o;
      const Vec<3>&a = (*face)[0], ab = (*face)[1] - a, ac = (*face)[2] - a, p = d.cross(ac), q = (o - a).cross(ab);
      const double det = ab.dot(p);
      if (std::abs(det) < 1e-12 * ab.norm() * ac.norm() * d.norm()) continue;
      const double at = ac.dot(q) / det, v = (o - a).dot(p) / det, w = d.dot(q) / det;
      if (at > inside && at < 1.0 - inside && v > inside && w > inside && v + w < 1.0 - inside) return o + at * d;
    }
  return std::nullopt;
}

}  // namespace

std::optional<MeshFault> fault_of(const TriangleMesh& mesh) {
  const VecArray<3>& points = mesh.triangles().points;
  const std::vector<Facet>& facets = mesh.triangles().facets;
  std::map<std::pair<Index, Index>, std::vector<std::pair<Index, bool>>> edges;
  for (Index f = 0; f < facets.size(); ++f) {
    if (mesh.normal(f).isZero(0.5)) return MeshFault{fmt::format("facet {} has no area", f + 1), points[facets[f][0]]};
    for (std::size_t c = 0; c < 3; ++c) {
      const Index a = facets[f][c], b = facets[f][(c + 1) % 3];
      edges[std::minmax(a, b)].push_back({f, a < b});
    }
  }
  for (const auto& [edge, users] : edges) {
    const Vec<3> at = 0.5 * (points[edge.first] + points[edge.second]);
    if (users.size() == 1)
      return MeshFault{fmt::format("an edge of facet {} has no facet on its other side: the surface is open there",
                                   users[0].first + 1),
                       at};
    if (users.size() % 2 != 0)
      return MeshFault{
          fmt::format("{} facets meet at an edge, {} among them; expected two", users.size(), users[0].first + 1), at};
    const auto forward = std::count_if(users.begin(), users.end(), [](const auto& user) { return user.second; });
    if (2 * static_cast<std::size_t>(forward) != users.size())
      return MeshFault{
          fmt::format("facets {} and {} are turned against each other", users[0].first + 1, users[1].first + 1), at};
  }
  std::optional<MeshFault> fault;
  const auto corners = [&](Index f) {
    return std::array<Vec<3>, 3>{points[facets[f][0]], points[facets[f][1]], points[facets[f][2]]};
  };
  for (Index f = 0; f < facets.size() && !fault; ++f) {
    const auto t = corners(f);
    mesh.for_each_touching(t[0].cwiseMin(t[1]).cwiseMin(t[2]), t[0].cwiseMax(t[1]).cwiseMax(t[2]), [&](Index g) {
      if (g <= f || fault) return;
      if (const auto at = crossing_of(t, corners(g)))
        fault = MeshFault{fmt::format("facets {} and {} cross each other", f + 1, g + 1), *at};
    });
  }
  return fault;
}

}  // namespace poretwin
