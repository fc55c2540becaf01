// Degree of saturation of the soil from the water around it.
#pragma once

#include "solid_solver/numerics/exchange.hpp"
#include "solid_solver/setup.hpp"

#include <algorithm>

namespace poretwin::solid {

/// Coverage of each particle by the soil, sum V W [1], including the particle itself: 1 inside, less at faces.
template <int D>
ScalarArray own_coverage(const Setup<D>& setup, const State<D>& state) {
  const double h = setup.smoothing_length, self = sph::WendlandC2<D>::value(0.0, h);
  ScalarArray own(state.particles.size());
  for (std::size_t i = 0; i < own.size(); ++i) own[i] = state.nodes[i].volume * self;
  for_each_pair(state.near.pairs, [&](std::size_t i, std::size_t j, std::size_t, bool both) {
    const Node<D>&a = state.nodes[i], &b = state.nodes[j];
    const double value = sph::WendlandC2<D>::value((a.position - b.position).norm(), h);
    own[i] += b.volume * value;
    if (both) own[j] += a.volume * value;
  });
  return own;
}

/// Degree of saturation s_r of every particle, Eq. (90). It increases from the soil's initial saturation to 1 with the
/// ratio of the coverage by water [0..1] to the coverage by soil. With this ratio a wetted face becomes as wet as the
/// soil behind it. A ratio of 95 % counts as full, since the coverage of disordered points scatters by some percent.
/// own() returns own_coverage() by reference and is called only where there is water.
template <int D, class Own>
void degree_of_saturation(const std::vector<Soil>& soils, const State<D>& state, const OrZero<double>& coverage,
                          Own&& own, OrZero<double>& saturation) {
  const std::size_t n = state.particles.size();
  saturation.allocate(n);
  const bool wet = std::any_of(coverage.begin(), coverage.end(), [](double c) { return c > 0.0; });
  const ScalarArray* around = wet ? &own() : nullptr;
  for (std::size_t i = 0; i < n; ++i) {
    const double initial = soils[state.particles.material[i]].initial_saturation;
    const double share = coverage[i] > 0.0
                             ? std::min(1.0, coverage[i] / (exchange::full_saturation * std::min(1.0, (*around)[i])))
                             : 0.0;
    saturation.set(i, initial + (1.0 - initial) * share);
  }
}

}  // namespace poretwin::solid
