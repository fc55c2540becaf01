// Sources of volume in the pressure equation besides pressure and drag, and the repair of the particles' packing.
#pragma once

#include "fluid_solver/state.hpp"

namespace poretwin::fluid {

/// Whether the density of open water is measured by density_weight, which hardly depends on the order of its particles.
template <int D>
bool uses_density_weight(const Setup<D>& setup);

/// Displacement of each particle from its birthplace as a fraction in [0, 1]; at 1 its packing error counts in full.
template <int D>
ScalarArray moved(const Particles<D>& p);

/// Time in which the packing of free water is repaired [s]. spacing: m.
template <int D>
double free_repair_time(const Setup<D>& setup, double spacing);

/// Time in which a packing error at particle a is removed [s]. interval: length of the window [s].
template <int D>
double repair_time(const Setup<D>& setup, const Particles<D>& p, std::size_t a, const SoilView<D>& view,
                   double interval);

/// Packing around particle a relative to a lattice's, minus 1. full: sum V W over that of a lattice, or the measure
/// that replaces it in open water. loose_counts: looseness counts in open water within reach of a surface, too.
template <int D>
double packing_error(const Setup<D>& setup, const Particles<D>& p, const Stencil<D>& s, std::size_t a, double full,
                     bool loose_counts = false);

/// Rate of expansion of each particle's volume [1/s], as a source in the pressure equation. It consists of the repair
/// of the packing, the curvature of the motion in time, and the strain of the soil that its mapped motion does not
/// show.
template <int D>
ScalarArray volume_source(const Setup<D>& setup, State<D>& state, const Stencil<D>& s, const SoilView<D>& view,
                          std::span<const Mat<D>> velocity_gradient, double interval);

/// Flux of the skeleton [m/s] in earlier windows beyond the flux that was predicted, as it is applied to the water's
/// volume in this window: no faster than it arose. After a long window each short one applies its fraction of it. Empty
/// where no skeleton responds.
template <int D>
VecArray<D> deferred_flux(const Setup<D>& setup, State<D>& state, const SoilView<D>& view, double interval);

/// Displacements [m] by which the pore water catches up with the soil: drag moved it also where the soil departed from
/// the prediction, of which `deferred` is the part of this window. Empty where no such soil is near.
template <int D>
VecArray<D> catch_up(const Setup<D>& setup, const SoilView<D>& view, std::span<const Vec<D>> deferred, double interval,
                     const State<D>& state);

/// Displacements [m] that repair the packing where the pressure cannot repair it.
template <int D>
VecArray<D> repair(const Setup<D>& setup, const State<D>& state, const Stencil<D>& s, const SoilView<D>& view,
                   double interval);

}  // namespace poretwin::fluid
