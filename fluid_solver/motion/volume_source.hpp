// What volume the particles must give off or take in beside what pressure and drag move, and how their packing is
// repaired.
#pragma once

#include "fluid_solver/state.hpp"

namespace poretwin::fluid {

/// Whether the density of the water is measured in a way that hardly depends on the order of its particles.
template <int D>
bool tells_density(const Setup<D>& setup);

/// How far each particle has come from its birthplace, in [0, 1]; 1: far enough for its packing to count.
template <int D>
ScalarArray moved(const Particles<D>& p);

/// Time in which the packing of free water is repaired [s].
template <int D>
double free_repair_time(const Setup<D>& setup, double spacing);

/// Time in which a packing error is undone [s].
template <int D>
double repair_time(const Setup<D>& setup, const Particles<D>& p, std::size_t a, const SoilView<D>& view,
                   double interval);

/// Relative excess of the packing around particle a over a lattice's. full: sum V W over that of a lattice, or the
/// measure that replaces it in open water.
template <int D>
double packing_error(const Setup<D>& setup, const Particles<D>& p, const Stencil<D>& s, std::size_t a, double full);

/// Volume each particle must give off [1/s]: packing repair, the window's curvature in time and the soil's deformation
/// beyond the prediction.
template <int D>
ScalarArray volume_source(const Setup<D>& setup, State<D>& state, const Stencil<D>& s, const SoilView<D>& view,
                          std::span<const Mat<D>> velocity_gradient, double interval);

/// Displacements that repair the packing where no pressure does [m].
template <int D>
VecArray<D> repair(const Setup<D>& setup, const State<D>& state, const Stencil<D>& s, const SoilView<D>& view,
                   double interval);

}  // namespace poretwin::fluid
