// The network of a case in 3D.
#pragma once

#include "pore_solver/network.hpp"

namespace poretwin::pore {

/// The network of a 3D case. Points fill each soil on a lattice.
/// Cells are cut off at planes of the soil's surface, the nearest plane first. Where the surface is convex, its facets
/// bound the cells exactly. Where the soil goes around a hole or a notch, a cell ends at the plane of the nearest facet
/// and loses its part beyond this plane. Throws CaseError where the soil's border is not closed or a soil has no point.
Network make_network_3d(const Case& scene);

}  // namespace poretwin::pore
