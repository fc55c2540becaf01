// Rough walls: fixed rows of the soil's own particles behind the wall. Soil that flows over these rows shears against
// soil that has a stress and a density, as over a bed of glued grains.
#pragma once

#include "solid_solver/setup.hpp"

namespace poretwin::solid {

/// Appends the fixed particles of all rough walls, each of the soil that lies nearest, and counts them in
/// particles.held. Only position, mass, volume and material are set. Walls need ends in 2D. In 3D, where walls are
/// planes, the rows end at the domain's box. Throws CaseError where ends or box are missing.
template <int D>
void hold_soil_behind_rough_walls(const Case& scene, const Setup<D>& setup, Particles<D>& particles);

}  // namespace poretwin::solid
