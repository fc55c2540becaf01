// Interpolation of a field between the points at which it is computed.
#pragma once

#include "pore_solver/network.hpp"

#include <array>
#include <functional>
#include <optional>
#include <vector>

namespace poretwin::pore {

/// A place in the soil as weights of points around it. A value is linear in the triangle (3D: tetrahedron) of the
/// nearest point and its neighbours that contains the place (Voronoi cells belong to a Delaunay triangulation). Near
/// the border, where none contains the place, it is extrapolated linearly. All points lie in one soil, since gradients
/// jump at the border of two.
struct Probe {
  std::array<Index, 4> point{};
  std::array<double, 4> weight{};
  template <class Value>
  [[nodiscard]] double of(const Value& value) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < 4; ++i)
      if (weight[i] != 0.0) sum += weight[i] * value(point[i]);
    return sum;
  }
};

/// A straight line through the soil.
struct ProbeLine {
  double length = 0.0, step = 0.0;  ///< m; step: between two places
  ScalarArray place;    ///< m, distances of the places from its start, increasing; only places in the soil
  std::vector<Probe> probe;
};

class Probes {
 public:
  Probes(const Case& scene, const Network& network);
  /// The probe at x [m]; empty outside the soil.
  [[nodiscard]] std::optional<Probe> at(const Point3& x) const;
  /// Probes at places a quarter of a spacing apart, with both ends of the line.
  [[nodiscard]] ProbeLine along(const Point3& from, const Point3& to) const;

 private:
  /// The point nearest to x, in one soil or in all.
  [[nodiscard]] Index nearest(const Point3& x, std::optional<std::size_t> soil) const;
  /// The probe at x in 3D: of the tetrahedra of `a` and three of its neighbours the one whose least weight at x is
  /// largest; where all points lie in a plane, of the triangles; on a line, of the pairs.
  [[nodiscard]] Probe in_space(const Point3& x, Index a) const;

  const Case& scene_;
  const Network& network_;
  std::vector<std::vector<Index>> neighbours_;  ///< of each point: its neighbours in its own soil, in 2D anticlockwise
};

}  // namespace poretwin::pore
