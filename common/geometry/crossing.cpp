#include "common/geometry/crossing.hpp"

#include "common/geometry/pieces.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace poretwin {
namespace {

/// On which side of the line from a to b x lies: -1, 0 (on the line, to within rounding), or 1.
int side(const Point3& a, const Point3& b, const Point3& x) {
  const double area = cross(b - a, x - a);
  const double slack = 1e-12 * ((b - a).norm() * (x - a).norm() + 1e-3 * (b - a).squaredNorm());
  return area > slack ? 1 : area < -slack ? -1 : 0;
}

}  // namespace

std::optional<Crossing> self_crossing(const std::vector<Point3>& points, bool closed) {
  const std::size_t n = points.size(), pieces = closed ? n : n - 1;
  if (n < 3) return std::nullopt;
  const auto end = [&](std::size_t i) -> const Point3& { return points[(i + 1) % n]; };
  // Only pieces whose extents along x overlap are compared.
  std::vector<std::size_t> order(pieces);
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto lowest = [&](std::size_t i) { return std::min(points[i].x(), end(i).x()); };
  const auto highest = [&](std::size_t i) { return std::max(points[i].x(), end(i).x()); };
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return lowest(i) < lowest(j); });
  std::optional<Crossing> found;
  const auto note = [&](std::size_t i, std::size_t j, const Point3& at) {
    const auto [first, second] = std::minmax(i, j);
    if (!found || first < found->first || (first == found->first && second < found->second))
      found = Crossing{first, second, at};
  };
  for (std::size_t k = 0; k < pieces; ++k)
    for (std::size_t l = k + 1; l < pieces && lowest(order[l]) <= highest(order[k]); ++l) {
      const std::size_t i = std::min(order[k], order[l]), j = std::max(order[k], order[l]);
      if (j == i + 1 || (closed && i == 0 && j + 1 == pieces)) continue;  // neighbours share a point
      const Point3 &a = points[i], &b = end(i), &c = points[j], &d = end(j);
      const int of_c = side(a, b, c), of_d = side(a, b, d), of_a = side(c, d, a), of_b = side(c, d, b);
      if (of_c * of_d < 0 && of_a * of_b < 0) {
        note(i, j, a + cross(c - a, d - c) / cross(b - a, d - c) * (b - a));
        continue;
      }
      // Whether the line goes through a piece at this corner: the points before and after lie on different sides.
      const auto goes_through = [&](std::size_t piece, std::size_t corner, const Point3& from, const Point3& to) {
        if (side(from, to, points[corner]) != 0) return false;
        const double along = (to - from).dot(points[corner] - from) / (to - from).squaredNorm();
        if (!(along > 1e-9 && along < 1.0 - 1e-9)) return false;
        if (!closed && (corner == 0 || corner + 1 == n)) return false;
        const std::size_t before = (corner + n - 1) % n, after = (corner + 1) % n;
        if (before == piece || after == piece || before == (piece + 1) % n || after == (piece + 1) % n) return false;
        return side(from, to, points[before]) * side(from, to, points[after]) < 0;
      };
      for (const std::size_t corner : {j, (j + 1) % n})
        if (goes_through(i, corner, a, b)) note(i, j, points[corner]);
      for (const std::size_t corner : {i, (i + 1) % n})
        if (goes_through(j, corner, c, d)) note(i, j, points[corner]);
    }
  return found;
}

}  // namespace poretwin
