// Regimes of water in soil: either drag dominates the water's motion, or the water moves as free water does.
#pragma once

#include "fluid_solver/exchange/soil_view.hpp"
#include "fluid_solver/motion/step_limits.hpp"
#include "fluid_solver/state.hpp"

namespace poretwin::fluid {

/// The quantities that determine the regime in a window of `interval` [s].
template <int D>
SeepageRegime seepage_regime(const Setup<D>& setup, double interval) {
  return {setup.density, quasi_static_speed(setup), interval > wave_interval(setup)};
}

/// Sets every particle's regime.
template <int D>
void set_regimes(const SoilView<D>& view, const SeepageRegime& regime, Particles<D>& p) {
  parallel_for(p.size(), [&](std::size_t a) {
    p.in_seepage[a] = in_seepage_regime<D>(view, a, p.velocity[a], spacing_of<D>(p.volume[a]), regime) ? 1 : 0;
  });
}

/// Whether drag, not inertia, dominates the motion of particle a.
template <int D>
bool is_drag_dominated(const Setup<D>& setup, const Particles<D>& p, const SoilView<D>& view, std::size_t a) {
  return view.mask[a] > 0.5 && !inertia_rules(p.void_fraction[a], setup.density, view.drag[a],
                                              spacing_of<D>(p.volume[a]), setup.weight.norm() / setup.density);
}

/// Whether all water is in the seepage regime and dominated by drag, so that no water moves as free water does.
template <int D>
bool all_quasi_static(const Setup<D>& setup, const Particles<D>& p, const SoilView<D>& view) {
  return parallel_all(view.size(),
                      [&](std::size_t a) { return p.in_seepage[a] != 0 && is_drag_dominated<D>(setup, p, view, a); });
}

/// Takes a particle out of the seepage regime where most of the water in the soil around it is not in that regime (in
/// short windows only). Otherwise its gradient would ignore the free surface beside it, while the skeleton there
/// yields: in a pocket of tailings that run out this made a pressure of 5 MPa in one window. All ranks call this.
template <int D>
void flow_together(const Setup<D>& setup, const Stencil<D>& s, Particles<D>& p) {
  const auto in_soil = [&](std::size_t a, bool seeping) {
    return p.mask[a] > 0.5 && (p.in_seepage[a] != 0) == seeping;
  };
  if (!setup.coupled || !setup.domain.any_of(p.size(), [&](std::size_t a) { return in_soil(a, false); })) return;
  const std::vector<char> alone = s.flags_with_copies(p.in_seepage);
  const auto mask = s.template with_copies<double>(p.mask);
  parallel_for(p.size(), [&](std::size_t a) {
    if (!in_soil(a, true)) return;
    double free = 0.0, all = 0.0;
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
      const Index q = s.parent[s.other[k]];
      if (q >= s.n_particles || mask[q] <= 0.5) continue;
      const double value = s.value(a, s.other[k]);
      all += value;
      if (alone[q] == 0) free += value;
    }
    if (free > 0.5 * all) p.in_seepage[a] = 0;
  });
}

}  // namespace poretwin::fluid
