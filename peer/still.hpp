// A phase at rest, computed from the case alone: still water with hydrostatic pressure; soil in equilibrium under its
// buoyant weight. It stands in for a solver; the conformance suite also sends its fields to a solver.
#pragma once

#include "common/case/case.hpp"
#include "common/coupling/mock.hpp"

#include <memory>

namespace poretwin::peer {

/// Value at x [m] of an exchanged field of the standard contract (docs/protocol.md) in this state of rest; 0 for other
/// fields.
double still_value(const Case& scene, const std::string& field, const Point3& x);

/// Lattice points, with their images behind walls as ghosts. For the solid they lie in the case's soils; for the fluid
/// in its regions of water or, in a case without such regions, in its soils.
coupling::PointSet still_points(const Case& scene, coupling::Role role);

/// A phase that publishes still_value() at still_points() in every window, whatever it receives.
std::unique_ptr<Phase> make_still(const Case& scene, coupling::Role role);

}  // namespace poretwin::peer
