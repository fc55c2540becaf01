#include "common/case/basin.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin {

double basin_level(const Series& area, double volume) {
  const auto& knots = area.knots;
  double rest = std::max(0.0, volume);
  for (std::size_t i = 0;; ++i) {
    const auto [z, A] = knots[i];
    const bool last = i + 1 == knots.size();
    const double slope = last ? 0.0 : (knots[i + 1].second - A) / (knots[i + 1].first - z);
    if (!last) {
      const double whole = area.integral(z, knots[i + 1].first);
      if (rest > whole) {
        rest -= whole;
        continue;
      }
    }
    // Solves A y + slope y^2 / 2 = rest for y, in a form without cancellation.
    return z + 2.0 * rest / (A + std::sqrt(std::max(0.0, A * A + 2.0 * slope * rest)));
  }
}

double basin_first_level(const WaterFace& face) {
  const double bottom = face.basin_area->knots.front().first;
  return face.head ? std::max(bottom, face.head->at(0.0)) : bottom;
}

}  // namespace poretwin
