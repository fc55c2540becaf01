// Water beside walls that are drawn as lines, as the solver sees it: pairs of particles and their weights.
#pragma once

#include "common/geometry/shapes.hpp"
#include "fluid_solver/boundary/walls.hpp"
#include "fluid_solver/discretisation/stencil.hpp"
#include "tests/fluid/scenes.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace poretwin::fluid::test {

inline constexpr double dx = 0.04;  ///< particle spacing [m]

/// The water of the scene as the solver sees it at first, with its particles moved by up to `jitter` spacings.
inline Stencil<2> seen(const Case& scene, double jitter) {
  const Walls<2> walls(scene, {});
  VecArray<2> x;
  ScalarArray volume;
  for (const auto& region : scene.fluid.regions) {
    const auto lattice = fill<2>(region, dx, Point3(0.5, 0.5, 0.5), jitter, 7);
    x.insert(x.end(), lattice.position.begin(), lattice.position.end());
    volume.resize(x.size(), lattice.volume);
  }
  return make_stencil<2>(x, volume, {}, walls.planes, {}, false, worth_threads_in_pairs, walls.sight);
}

/// The largest difference between the two entries of a pair in the rows of its particles, over the largest entry.
inline double asymmetry(const Stencil<2>& s) {
  std::map<std::pair<Index, Index>, double> sum;
  double largest = 0.0, worst = 0.0;
  for (std::size_t a = 0; a < s.n_real; ++a)
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k)
      if (const Index b = s.parent[s.other[k]]; b != a)
        sum[{static_cast<Index>(a), b}] += static_cast<double>(s.gradient_factor[k]);
  for (const auto& [pair, factor] : sum) {
    const auto back = sum.find({pair.second, pair.first});
    largest = std::max(largest, factor);
    worst = std::max(worst, std::abs(factor - (back == sum.end() ? 0.0 : back->second)));
  }
  return worst / largest;
}

}  // namespace poretwin::fluid::test
