// Interpolation of a field between the points at which it is computed.
#pragma once

#include "pore_solver/network.hpp"

#include <array>
#include <functional>
#include <optional>
#include <vector>

namespace poretwin::pore {

/// A place in the soil as weights of points around it. A value is interpolated linearly in the triangle (3D:
/// tetrahedron) that contains the place; its corners are the nearest point and neighbours of this point (the dual of
/// Voronoi cells is a Delaunay triangulation). Near the border, where no triangle contains the place, the value is
/// extrapolated linearly. All points of a probe lie in one soil, since gradients jump at the border of two soils.
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
  double length = 0.0, step = 0.0;  ///< m; step: between two successive places
  ScalarArray place;    ///< m, distances of the places from the line's start, increasing; only places in the soil
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
  /// The point nearest to x, in one soil or in all soils.
  [[nodiscard]] Index nearest(const Point3& x, std::optional<std::size_t> soil) const;
  /// The probe at x in 3D. It uses the tetrahedron of `a` and three of its neighbours whose least weight at x is
  /// largest; where all points lie in a plane it uses a triangle, on a line a pair.
  [[nodiscard]] Probe in_space(const Point3& x, Index a) const;

  const Case& scene_;
  const Network& network_;
  std::vector<std::vector<Index>> neighbours_;  ///< of each point: its neighbours in its own soil, in 2D anticlockwise
};

}  // namespace poretwin::pore
