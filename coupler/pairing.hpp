// Mapping between two sets of the same points in two solvers: water as a field is computed on the soil's particles.
// Each point takes its partner's values unchanged (docs/decisions/0023-field-on-moving-soil.md).
#pragma once

#include "coupler/mapping.hpp"

namespace poretwin::coupling {

/// Partners are found once, from the first positions, and kept however the points move. Points of the solid without a
/// partner, behind rough walls, take the values of the nearest point that has one. Where a point of the fluid has none,
/// the sets are not the same, and all fields are mapped as between clouds. Conservative amounts always are.
std::unique_ptr<SpatialMapping> make_paired_mapping(int dimension);

}  // namespace poretwin::coupling
