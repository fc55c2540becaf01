#include "solid_solver/exchange/pore_water.hpp"

#include "common/geometry/shapes.hpp"

#include <algorithm>
#include <limits>

namespace poretwin::solid {

std::optional<double> prescribed_pressure(const WaterSetup& setup, const Point3& x, double t) {
  for (const auto& water : setup.prescribed) {
    if (water.region && !contains(*water.region, x, setup.dimension)) continue;
    if (water.pressure) return water.pressure->at(t);
    double head = water.head->at(t);
    if (water.to_head) {
      const Point3 way = water.to - water.from;
      const double share = std::clamp((x - water.from).dot(way) / way.squaredNorm(), 0.0, 1.0);
      head += share * (water.to_head->at(t) - head);
    }
    // p = rho_w g (h - z), z = -x . g / |g|.
    const Point3& g = setup.gravity;
    const double pressure = setup.density * (g.norm() * head + g.dot(x));
    if (pressure > 0.0) return pressure;
    return std::nullopt;
  }
  return std::nullopt;
}

double next_change_after(const WaterSetup& setup, double t) {
  double next = std::numeric_limits<double>::infinity();
  for (const auto& water : setup.prescribed)
    for (const auto* series : {&water.pressure, &water.head, &water.to_head}) {
      if (!*series) continue;
      for (const auto& knot : (*series)->knots)
        if (knot.first > t + 1e-9 * std::abs(t)) next = std::min(next, knot.first);
    }
  return next;
}

}  // namespace poretwin::solid
