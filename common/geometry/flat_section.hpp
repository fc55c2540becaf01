// A flat section through space, through which flows are summed (3D).
#pragma once

#include "common/core/vector.hpp"

#include <Eigen/Geometry>

#include <cmath>
#include <vector>

namespace poretwin {

/// A flat polygon with three corners or more, convex or not. Its normal follows from the order of its corners by the
/// right-hand rule.
class FlatSection {
 public:
  explicit FlatSection(std::vector<Point3> corners) : corners_(std::move(corners)) {
    for (std::size_t i = 1; i + 1 < corners_.size(); ++i)
      normal_ += 0.5 * (corners_[i] - corners_[0]).cross(corners_[i + 1] - corners_[0]);
    area_ = normal_.norm();
    if (area_ > 0.0) normal_ /= area_;
  }
  [[nodiscard]] const Point3& normal() const { return normal_; }
  [[nodiscard]] double area() const { return area_; }  ///< m2
  /// Largest distance of a corner from the plane through the first corner [m].
  [[nodiscard]] double unevenness() const {
    double most = 0.0;
    for (const Point3& x : corners_) most = std::max(most, std::abs(normal_.dot(x - corners_[0])));
    return most;
  }

  /// 1 if the straight line from a to b leads through the section along its normal, -1 if against it, 0 if it misses
  /// the section. Points on the plane count as in front of it, and places on the rim as inside on one side only, so
  /// that adjacent sections count each line once.
  [[nodiscard]] double crossed(const Point3& a, const Point3& b) const {
    const double p = normal_.dot(a - corners_[0]), q = normal_.dot(b - corners_[0]);
    if ((p > 0.0) == (q > 0.0) || !contains(a + p / (p - q) * (b - a))) return 0.0;
    return q > 0.0 ? 1.0 : -1.0;
  }

 private:
  /// Whether a ray in the plane from x crosses the polygon's sides an odd number of times.
  [[nodiscard]] bool contains(const Point3& x) const {
    // The plane is projected along the axis to which it is most perpendicular.
    Eigen::Index axis = 0;
    normal_.cwiseAbs().maxCoeff(&axis);
    const Eigen::Index u = (axis + 1) % 3, v = (axis + 2) % 3;
    bool inside = false;
    for (std::size_t i = 0, j = corners_.size() - 1; i < corners_.size(); j = i++) {
      const Point3 &c = corners_[i], &d = corners_[j];
      if ((c[v] > x[v]) != (d[v] > x[v]) && x[u] < c[u] + (x[v] - c[v]) / (d[v] - c[v]) * (d[u] - c[u]))
        inside = !inside;
    }
    return inside;
  }

  std::vector<Point3> corners_;
  Point3 normal_ = Point3::Zero();
  double area_ = 0.0;
};

}  // namespace poretwin
