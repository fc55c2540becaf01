// Reading a field between the points that it lives on.
#pragma once

#include "pore_solver/network.hpp"

#include <array>
#include <functional>
#include <optional>
#include <vector>

namespace poretwin::pore {

/// A place in the soil as weights of the points around it. Linear in the triangle of the nearest point and two of its
/// neighbours in which the place lies (the Delaunay triangulation belongs to Voronoi cells), and from there linearly on
/// up to the border, where no triangle lies around the place. All three are of one soil: at the border of two the
/// gradient jumps.
struct Probe {
  std::array<Index, 3> point{};
  std::array<double, 3> weight{};
  template <class Value>
  [[nodiscard]] double of(const Value& value) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < 3; ++i)
      if (weight[i] != 0.0) sum += weight[i] * value(point[i]);
    return sum;
  }
};

/// A straight line through the soil.
struct ProbeLine {
  double length = 0.0;  ///< m
  ScalarArray place;    ///< m from its start, increasing; only places in the soil
  std::vector<Probe> probe;
};

class Probes {
 public:
  Probes(const Case& scene, const Network& network);
  /// Nothing outside the soil.
  [[nodiscard]] std::optional<Probe> at(const Point3& x) const;
  /// Places a quarter of a spacing apart, both ends among them.
  [[nodiscard]] ProbeLine along(const Point3& from, const Point3& to) const;

 private:
  /// Of one soil, or of all.
  [[nodiscard]] Index nearest(const Point3& x, std::optional<std::size_t> soil) const;

  const Case& scene_;
  const Network& network_;
  std::vector<std::vector<Index>> neighbours_;  ///< of each point in its own soil, anticlockwise
};

}  // namespace poretwin::pore
