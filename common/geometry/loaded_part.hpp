// The part of a plane on which a load acts or that a plate fills (3D).
#pragma once

#include "common/case/case.hpp"
#include "common/geometry/shapes.hpp"

#include <array>

namespace poretwin {

/// A rectangle along the axes.
struct LoadedPart {
  int across = 0;                                      ///< axis of the plane's normal
  std::array<int, 2> axes{};                           ///< axes of the rectangle's sides
  Point3 low = Point3::Zero(), high = Point3::Zero();  ///< m, corners on the plane
  [[nodiscard]] double area() const {                  ///< m2
    return std::max(0.0, high[axes[0]] - low[axes[0]]) * std::max(0.0, high[axes[1]] - low[axes[1]]);
  }
  /// Whether a place lies above or below the rectangle.
  [[nodiscard]] bool covers(const Point3& x) const {
    return std::all_of(axes.begin(), axes.end(), [&](int d) { return x[d] >= low[d] && x[d] <= high[d]; });
  }
};

/// Whether a shape is a box along the axes as drawn: not turned, scaled, moved, or cut by others.
inline bool plain_box(const Shape& shape) {
  return shape.kind == Shape::Kind::box && !shape.placement && shape.within.empty() && shape.without.empty();
}

/// The part of a load's or plate's plane that lies in its box and within the bounds of all soil. The plane is normal to
/// an axis.
inline LoadedPart loaded_part(const Case& scene, const Face& face) {
  LoadedPart part;
  face.normal.cwiseAbs().maxCoeff(&part.across);
  part.axes = {(part.across + 1) % 3, (part.across + 2) % 3};
  Point3 lower = Point3::Constant(HUGE_VAL), upper = -lower;
  for (const Soil& soil : scene.soils) {
    const auto [low, high] = bounds(soil.shape);
    lower = lower.cwiseMin(low);
    upper = upper.cwiseMax(high);
  }
  part.low = lower.cwiseMax(face.within->min);
  part.high = upper.cwiseMin(face.within->max);
  part.low[part.across] = part.high[part.across] = face.point[part.across];
  return part;
}

}  // namespace poretwin
