// Keeping particles evenly spaced: shifting along the gradient of concentration, and pushing apart pairs that come too
// close.
#pragma once

#include "fluid_solver/stencil.hpp"
#include "fluid_solver/surface.hpp"

namespace poretwin::fluid {

/// Displacements [m] that even out the packing; moved[a] in [0, 1] scales them (0: at rest, nothing to repair).
/// Shifting is (0.5 h |v| dt + 0.01 h^2) grad C (after Lind et al. 2012), along the surface only for surface particles.
template <int D>
VecArray<D> packing_displacements(const Stencil<D>& s, std::span<const Vec<D>> velocity, std::span<const double> moved,
                                  std::span<const Surface> flags, double interval) {
  VecArray<D> shift(s.n_real, Vec<D>::Zero());
  for (std::size_t a = 0; a < s.n_real; ++a) {
    if (moved[a] == 0.0 || flags[a] == Surface::lone) continue;
    const double h = s.length[a], spacing = h / smoothing_ratio;
    // Even surroundings have sum V grad W = 0; it points to where particles are.
    Vec<D> d = -(0.5 * h * velocity[a].norm() * interval + 0.01 * h * h) * s.normal[a];
    if (flags[a] == Surface::surface) {
      const Vec<D> normal = s.normal[a].normalized();
      d -= normal.dot(d) * normal;
    }
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
      const Index j = s.other[k];
      const Vec<D> ba = s.position[j] - s.position[a];
      const double r = ba.norm(), limit = 0.8 * 0.5 * (h + s.length[j]) / smoothing_ratio;
      if (r < limit && r > 0.0) d -= 0.25 * (limit - r) / r * ba;
    }
    const double length = d.norm(), most = 0.1 * spacing;
    if (length > most) d *= most / length;
    shift[a] = moved[a] * d;
  }
  return shift;
}

}  // namespace poretwin::fluid
