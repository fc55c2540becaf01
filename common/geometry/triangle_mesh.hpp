// Closed surfaces of triangles. A tree of boxes gives inside or outside, distance, and nearest facets.
#pragma once

#include "common/core/vector.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

namespace poretwin {

using Facet = std::array<Index, 3>;

/// Points and triangles, as in a file or a primitive. Facets are counter-clockwise as seen from outside.
struct Triangles {
  VecArray<3> points;  ///< m
  std::vector<Facet> facets;
};

class TriangleMesh {
 public:
  /// The surface must be closed and oriented (`fault_of`); otherwise the functions below give no meaningful results.
  explicit TriangleMesh(Triangles triangles);

  /// Winding number of the surface around x: 1 inside, 0 outside (Jacobson et al. 2013). Far parts of the surface are
  /// approximated as dipoles (Barill et al. 2018).
  [[nodiscard]] double winding_number(const Vec<3>& x) const;
  /// Whether x lies inside the closed surface. It does not outside the surface's box. Otherwise the side of the nearest
  /// facet decides, if the nearest point lies within that facet. If it lies on an edge, the winding number decides,
  /// which costs ten times as much.
  [[nodiscard]] bool contains(const Vec<3>& x) const;

  struct Nearest {
    Index facet = 0;
    Vec<3> point = Vec<3>::Zero();  ///< m
    double distance = 0.0;          ///< m
  };
  /// The nearest point of the surface within a range [m] of x; empty if there is none.
  [[nodiscard]] std::optional<Nearest> nearest(const Vec<3>& x, double range) const;
  /// The nearest of the points on facets within a range [m] of x for which admits(Nearest) holds. Leaves out facets
  /// whose normals are all within an angle of a direction for which skips(direction, cosine of the angle) holds.
  template <class Skips, class Admits>
  [[nodiscard]] std::optional<Nearest> nearest_if(const Vec<3>& x, double range, const Skips& skips,
                                                  const Admits& admits) const {
    std::optional<Nearest> found;
    double least = range * range;
    std::array<std::pair<Index, double>, 64> stack;
    std::size_t depth = 0;
    stack[depth++] = {0, nodes_[0].distance2(x)};
    while (depth > 0) {
      const auto [n, away] = stack[--depth];
      const Node& node = nodes_[n];
      if (away > least || skips(node.direction, node.spread)) continue;
      if (node.right != 0) {
        // The nearer child first.
        const std::pair<Index, double> one{n + 1, nodes_[n + 1].distance2(x)},
            other{node.right, nodes_[node.right].distance2(x)};
        stack[depth++] = one.second < other.second ? other : one;
        stack[depth++] = one.second < other.second ? one : other;
        continue;
      }
      for (Index k = node.first; k < node.first + node.count; ++k) {
        const Index f = facets_[k];
        const Vec<3> point = nearest_on(f, x);
        const double distance2 = (point - x).squaredNorm();
        if (distance2 > least || (found && distance2 == least && f > found->facet)) continue;
        const Nearest near{f, point, std::sqrt(distance2)};
        if (!admits(near)) continue;
        least = distance2;
        found = near;
      }
    }
    return found;
  }
  /// The nearest point on each facet within a range [m] of x, in no particular order.
  void for_each_near(const Vec<3>& x, double range, const std::function<void(const Nearest&)>& visit) const;
  /// Facets whose boxes touch the box from lower to upper.
  void for_each_touching(const Vec<3>& lower, const Vec<3>& upper, const std::function<void(Index)>& visit) const;
  /// The first intersection of the line from a to b with the surface, as a fraction of the line.
  [[nodiscard]] std::optional<double> crossing(const Vec<3>& a, const Vec<3>& b) const;

  /// Distance from the surface [m], positive inside; its magnitude is at most `range`.
  [[nodiscard]] double depth(const Vec<3>& x, double range) const;

  [[nodiscard]] std::size_t size() const { return facets_.size(); }
  [[nodiscard]] const Triangles& triangles() const { return triangles_; }
  /// Unit, outward.
  [[nodiscard]] const Vec<3>& normal(Index facet) const { return normals_[facet]; }
  [[nodiscard]] double volume() const { return volume_; }  ///< m3
  [[nodiscard]] std::pair<Vec<3>, Vec<3>> bounds() const { return {nodes_[0].lower, nodes_[0].upper}; }

 private:
  struct Node {
    Vec<3> lower, upper;         ///< m
    Vec<3> centre, area;         ///< of the facets below [m]; sum of their normals times areas [m2]
    Vec<3> direction;            ///< unit, middle of the normals below
    double spread = -1.0;        ///< least cosine between `direction` and one of the normals
    double radius = 0.0;         ///< m, around the centre
    Index first = 0, count = 0;  ///< of the facets, in the tree's order
    Index right = 0;             ///< second child (the first is the next node); 0: the node is a leaf
    [[nodiscard]] double distance2(const Vec<3>& x) const {
      return (lower - x).cwiseMax(x - upper).cwiseMax(0.0).squaredNorm();
    }
  };
  void build(Index first, Index count);
  template <class Visit, class Enter>
  void walk(const Enter& enter, const Visit& visit) const;
  [[nodiscard]] Vec<3> nearest_on(Index facet, const Vec<3>& x) const;
  [[nodiscard]] const Vec<3>& corner(Index facet, std::size_t c) const {
    return triangles_.points[triangles_.facets[facet][c]];
  }

  Triangles triangles_;
  VecArray<3> normals_;
  std::vector<Index> facets_;  ///< in the tree's order
  std::vector<Node> nodes_;
  double volume_ = 0.0;
};

/// The fault of a surface that must enclose a body, and its place.
struct MeshFault {
  std::string what;  ///< a sentence about facets, counted from 1
  Vec<3> at;         ///< m
};
/// The first fault of a surface: open edges, edges of more than two facets, neighbouring facets of opposite
/// orientation, facets without area, facets that cross. Empty if the surface has no fault.
std::optional<MeshFault> fault_of(const TriangleMesh& mesh);

/// Joins points that coincide. Facets of which two corners then coincide are left out.
Triangles joined(const Triangles& triangles);

/// The same triangles with the opposite orientation.
Triangles turned_round(Triangles triangles);

}  // namespace poretwin
