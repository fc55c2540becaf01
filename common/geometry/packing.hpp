// Particles in bodies with slanted or curved faces: as many as the volume requires, evenly, half a spacing inside.
#pragma once

#include "common/geometry/shapes.hpp"
#include "common/geometry/solid.hpp"

namespace poretwin {

/// The round(V / spacing^3) points of a lattice that lie deepest in the body. Their volumes sum to that of the body.
Lattice<3> deepest_in(const Solid& solid, double spacing, const Point3& offset);

/// Moves the particles of a body until they are evenly spaced, with the outermost half a spacing from its faces.
void pack(const Solid& solid, double spacing, Lattice<3>& lattice);

}  // namespace poretwin
