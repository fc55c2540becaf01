// Slip surfaces: plastic strain along a path of particles that joins two lines.
#pragma once

#include "solid_solver/numerics/readings.hpp"
#include "solid_solver/setup.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <vector>

namespace poretwin::solid {

/// Distance [m] of x from the straight line between two ends.
template <int D>
double distance_from_line(const Vec<D>& x, const Vec<D>& begin, const Vec<D>& end) {
  const Vec<D> along = end - begin;
  const double share = along.isZero(0.0) ? 0.0 : std::clamp(along.dot(x - begin) / along.squaredNorm(), 0.0, 1.0);
  return (x - begin - share * along).norm();
}

/// The weakest link of a slip surface: the largest accumulated plastic strain [1] such that particles with at least
/// this strain form a path from one line to the other, each within 1.5 spacings of the next. Each line is given by two
/// of the four points [m], in the unloaded soil. A path begins and ends at particles within a spacing of a line. The
/// result is 0 where no soil joins the lines.
template <int D>
double weakest_link(const Setup<D>& setup, const State<D>& state, std::span<const Point3> lines) {
  struct Link {
    double strain;
    std::size_t a, b;
  };
  const auto& p = state.particles;
  const std::size_t n = p.free();
  std::vector<Link> links;
  for (std::size_t i = 0; i < n; ++i)
    for (const std::size_t line : {0, 1}) {
      const Vec<D> begin = lines[2 * line].head<D>(), end = lines[2 * line + 1].head<D>();
      if (distance_from_line<D>(p.position[i] - p.displacement[i], begin, end) < setup.spacing)
        links.push_back({p.plastic_strain[i], i, n + line});
    }
  for_each_pair(state.near.pairs, [&](std::size_t i, std::size_t j, std::size_t, bool) {
    if (i < n && j < n && (p.position[i] - p.position[j]).norm() < readings::link * setup.spacing)
      links.push_back({std::min(p.plastic_strain[i], p.plastic_strain[j]), i, j});
  });
  std::sort(links.begin(), links.end(), [](const Link& a, const Link& b) { return a.strain > b.strain; });
  std::vector<std::size_t> next(n + 2);  // next particle towards the representative of a set of joined particles
  std::iota(next.begin(), next.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (next[i] != i) i = next[i] = next[next[i]];
    return i;
  };
  for (const Link& link : links) {
    next[root(link.a)] = root(link.b);
    if (root(n) == root(n + 1)) return link.strain;
  }
  return 0.0;
}

}  // namespace poretwin::solid
