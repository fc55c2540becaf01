// Mapping between two sets that are the same points, given by two solvers: water as a field lives on the soil's
// particles. Each point takes its partner's values as they are (docs/decisions/0023-field-on-moving-soil.md).
#pragma once

#include "coupler/mapping.hpp"

namespace poretwin::coupling {

/// Partners are found once, where the two sets first lie, and stay however the points move. Points of the solid that
/// have none, behind rough walls, take the values of the nearest point that has one. Where a point of the fluid has
/// none the sets are not the same: they are mapped as clouds, and so are amounts.
std::unique_ptr<SpatialMapping> make_paired_mapping(int dimension);

}  // namespace poretwin::coupling
