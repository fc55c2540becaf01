// The free surface: which particles lie on it and what that does to the pressure equation.
#pragma once

#include "fluid_solver/stencil.hpp"

#include <cstdint>

namespace poretwin::fluid {

enum class Surface : std::uint8_t { interior, surface, lone };

/// Is there water within a kernel's reach in the cone of 45 degrees about the way outwards (after Marrone et al. 2010)?
template <int D>
bool covered(const Stencil<D>& s, std::size_t a) {
  const Vec<D> outwards = -s.normal[a].normalized();
  for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
    const Vec<D> ba = s.position[s.other[k]] - s.position[a];
    if (outwards.dot(ba) > 0.7071 * ba.norm()) return true;
  }
  return false;
}

/// By the deficit of the divergence of position, D in the interior (Lee et al. 2008).
/// A hole under pressure must not be taken for a surface: it would draw the water of a reservoir in at full head.
template <int D>
std::vector<Surface> find_surface(const Stencil<D>& s) {
  std::vector<Surface> flags(s.n_real, Surface::interior);
  for (std::size_t a = 0; a < s.n_real; ++a) {
    if (s.covered[a]) continue;
    if (s.divergence[a] < 0.4 * D)
      flags[a] = Surface::lone;
    else if (s.divergence[a] < 0.75 * D)
      flags[a] = Surface::surface;
  }
  return flags;
}

/// The surface's total pressure, at its distance outside the particle: what is added to row a,
/// coefficient * (ph_a - pressure).
struct SurfaceRow {
  double coefficient = 0.0;  ///< of the row weighted with the volume
  double pressure = 0.0;     ///< piezometric, Pa
};

/// weight: rho g [N/m3] as a vector; origin: where the piezometric pressure equals the total one.
template <int D>
SurfaceRow surface_row(const Stencil<D>& s, std::size_t a, double mobility, const Vec<D>& weight,
                       const Vec<D>& origin) {
  const double amount = s.normal[a].norm(), distance = s.surface_distance[a];
  if (amount == 0.0) return {};
  const Vec<D> x = s.position[a] - distance / amount * s.normal[a];
  return {s.volume[a] * 2.0 * mobility * amount / distance, s.surface_pressure[a] - weight.dot(x - origin)};
}

}  // namespace poretwin::fluid
