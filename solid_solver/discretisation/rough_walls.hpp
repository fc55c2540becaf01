// Rough walls: rows of the soil itself, held still behind the wall. What flows over them shears against soil that
// keeps its own stress and density, as over a bed of glued grains.
#pragma once

#include "solid_solver/setup.hpp"

namespace poretwin::solid {

/// Appends the held particles of all rough walls, of the soil that lies nearest, and counts them in particles.held.
/// Only position, mass, volume and material are filled. Walls have ends in 2D; in 3D, where they are planes, the rows
/// end with the domain's box. Throws CaseError without ends or box.
template <int D>
void hold_soil_behind_rough_walls(const Case& scene, const Setup<D>& setup, Particles<D>& particles);

}  // namespace poretwin::solid
