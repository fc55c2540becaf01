// A phase at rest, computed from the case alone: still water with its hydrostatic pressure; soil in equilibrium under
// its buoyant weight. It stands in for a solver, and is what the conformance suite sends to one.
#pragma once

#include "common/case/case.hpp"
#include "common/coupling/mock.hpp"

#include <memory>

namespace poretwin::peer {

/// Value of a field of the standard contract at x [m]; 0 for other fields.
double still_value(const Case& scene, const std::string& field, const Point3& x);

/// Lattice points of the case's soils, or of its water regions (where there are none, of its soils), with their images
/// behind walls as ghosts.
coupling::PointSet still_points(const Case& scene, coupling::Role role);

/// The phase that gives these values at these points, whatever it receives.
std::unique_ptr<Phase> make_still(const Case& scene, coupling::Role role);

}  // namespace poretwin::peer
