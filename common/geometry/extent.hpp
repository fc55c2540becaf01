// Corners and sides of shapes, and their extent along any direction.
#pragma once

#include "common/case/case.hpp"
#include "common/geometry/solid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace poretwin {

/// Corners of a polygon, in its order, or of a box (2D: counter-clockwise). A ball has no corners. Not for solids.
inline std::vector<Point3> corners_of(const Shape& shape, int dimension) {
  if (shape.kind != Shape::Kind::box) return shape.points;
  const auto &a = shape.min, &b = shape.max;
  std::vector<Point3> result{
      {a.x(), a.y(), a.z()}, {b.x(), a.y(), a.z()}, {b.x(), b.y(), a.z()}, {a.x(), b.y(), a.z()}};
  for (std::size_t i = 0; dimension == 3 && i < 4; ++i) result.emplace_back(result[i].x(), result[i].y(), b.z());
  return result;
}

/// Lowest and highest of x . direction over a shape [m]; direction: unit.
inline std::pair<double, double> extent(const Shape& shape, const Point3& direction, int dimension) {
  if (shape.solid) return shape.solid->extent(direction);
  if (shape.kind == Shape::Kind::ball) {
    const double middle = direction.dot(shape.centre);
    return {middle - shape.radius, middle + shape.radius};
  }
  double lowest = HUGE_VAL, highest = -HUGE_VAL;
  for (const auto& x : corners_of(shape, dimension)) {
    lowest = std::min(lowest, direction.dot(x));
    highest = std::max(highest, direction.dot(x));
  }
  return {lowest, highest};
}

/// The two sides from the first corner of a polygon, if the polygon is a rectangle at an angle to the axes.
inline std::optional<std::array<Point3, 2>> turned_rectangle(const Shape& shape) {
  if (shape.kind != Shape::Kind::polygon || shape.points.size() != 4) return std::nullopt;
  const auto& p = shape.points;
  const Point3 u = p[1] - p[0], v = p[3] - p[0];
  // Points are given with a few digits, and lose some of them far from the origin.
  const double size = u.norm() + v.norm(), close = 1e-5 * size + 1e-14 * p[0].norm();
  const bool rectangle = std::abs(u.dot(v)) < close * size && (p[2] - p[1] - v).norm() < close;
  const bool along_axes = std::min(std::abs(u.x()), std::abs(u.y())) < close;
  if (!rectangle || along_axes) return std::nullopt;
  return std::array<Point3, 2>{u, v};
}

}  // namespace poretwin
