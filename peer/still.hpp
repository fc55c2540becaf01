// What a phase says that is at rest, taken from the case alone: still water over its depth, soil that the water's
// buoyancy and its own stress hold. The stand-in for a solver, and what the conformance suite shows to one.
#pragma once

#include "common/case/case.hpp"
#include "common/coupling/mock.hpp"

#include <memory>

namespace poretwin::peer {

/// A field of the standard contract at x [m]; 0 for a field it does not know.
double still_value(const Case& scene, const std::string& field, const Point3& x);

/// Lattice points of the case's soils, or of its water regions (its soils, where there are none), with images behind
/// the walls as ghosts.
coupling::PointSet still_points(const Case& scene, coupling::Role role);

/// The phase that gives these values at these points, whatever it gets.
std::unique_ptr<Phase> make_still(const Case& scene, coupling::Role role);

}  // namespace poretwin::peer
