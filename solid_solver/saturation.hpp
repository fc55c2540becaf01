// Degree of saturation of the soil from the water around it.
#pragma once

#include "solid_solver/setup.hpp"

#include <algorithm>

namespace poretwin::solid {

/// Degree of saturation s_r of every particle, Eq. (90): water's coverage [0..1] over the soil's own, so that a wetted
/// face is as wet as the soil behind it, from the soil's initial saturation up to 1. The coverage of disordered points
/// scatters by some percent: 95 % counts as full.
template <int D>
void degree_of_saturation(const std::vector<Soil>& soils, const Setup<D>& setup, const State<D>& state,
                          const ScalarArray& coverage, ScalarArray& saturation) {
  constexpr double full = 0.95;
  const auto& pairs = state.near.pairs;
  const double h = setup.smoothing_length, self = sph::WendlandC2<D>::value(0.0, h);
  saturation.resize(state.particles.size());
  for (std::size_t i = 0; i < saturation.size(); ++i) {
    const double initial = soils[state.particles.material[i]].initial_saturation;
    saturation[i] = initial;
    if (coverage[i] <= 0.0) continue;
    double own = state.nodes[i].volume * self;
    for (Index m = pairs.offset[i]; m < pairs.offset[i + 1]; ++m) {
      const Node<D>& other = state.nodes[pairs.index[m]];
      own += other.volume * sph::WendlandC2<D>::value((state.nodes[i].position - other.position).norm(), h);
    }
    saturation[i] = initial + (1.0 - initial) * std::min(1.0, coverage[i] / (full * std::min(1.0, own)));
  }
}

}  // namespace poretwin::solid
