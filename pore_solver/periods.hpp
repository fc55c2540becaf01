// Images of points across the case's periodic sides.
#pragma once

#include "common/case/case.hpp"
#include "common/core/error.hpp"

#include <fmt/format.h>

#include <cmath>
#include <vector>

namespace poretwin::pore {

class Periods {
 public:
  explicit Periods(const Case& scene) : scene_(scene), close_(1e-6 * scene.fluid.particle_spacing) {}

  /// How far images continue the points beyond the sides, in spacings: farther than the cells at the sides reach.
  static constexpr double reach = 3.0;

  struct Image {
    Index point = 0;
    Point3 shift = Point3::Zero();  ///< m, from the point to its image
    /// Whether its pair with point a counts. Neighbours across a side meet twice: either point meets the other's image.
    [[nodiscard]] bool counts_for(Index a) const {
      if (point != a) return point > a;
      for (const double s : shift)
        if (s != 0.0) return s > 0.0;
      return false;
    }
  };
  /// The images of the points [m] near the periodic box.
  [[nodiscard]] std::vector<Image> images(const std::vector<Point3>& points) const {
    const General& g = scene_.general;
    std::vector<Point3> shifts{Point3::Zero()};
    for (const int axis : g.periodic)
      for (std::size_t i = 0, before = shifts.size(); i < before; ++i)
        for (const double sign : {-1.0, 1.0})
          shifts.emplace_back(shifts[i] + sign * (g.domain_max[axis] - g.domain_min[axis]) * Point3::Unit(axis));
    const double beyond = reach * scene_.fluid.particle_spacing;
    std::vector<Image> all;
    for (std::size_t i = 1; i < shifts.size(); ++i)
      for (std::size_t a = 0; a < points.size(); ++a) {
        const Point3 x = points[a] + shifts[i];
        bool near = true;
        for (const int axis : g.periodic)
          near = near && x[axis] > g.domain_min[axis] - beyond && x[axis] < g.domain_max[axis] + beyond;
        if (near) all.push_back({static_cast<Index>(a), shifts[i]});
      }
    return all;
  }
  /// Whether all these places [m] lie on one periodic side.
  template <class Places>
  [[nodiscard]] bool on_a_side(const Places& places) const {
    for (const int axis : scene_.general.periodic)
      for (const double side : {scene_.general.domain_min[axis], scene_.general.domain_max[axis]}) {
        bool all = true;
        for (const Point3& x : places) all = all && std::abs(x[axis] - side) < close_;
        if (all) return true;
      }
    return false;
  }
  /// Throws CaseError unless the place [m] at which cells of a point and of an image touch lies on the side that the
  /// image's shift crosses. Elsewhere a cell would reach beyond the side, where faces and other soil are not continued.
  void expect_on_a_side(const Point3& x, const Point3& shift) const {
    const General& g = scene_.general;
    for (const int axis : g.periodic)
      if (shift[axis] != 0.0 && std::abs(x[axis] - (shift[axis] > 0.0 ? g.domain_max : g.domain_min)[axis]) > close_)
        throw CaseError(
            fmt::format("{}: the soil on two opposite periodic sides does not fit together near [{:.6g}, {:.6g}, "
                        "{:.6g}] m: expected the same soil on both, on a lattice",
                        scene_.path.string(), x.x(), x.y(), x.z()));
  }

 private:
  const Case& scene_;
  double close_;  ///< m, distance within which a place counts as on a side
};

}  // namespace poretwin::pore
