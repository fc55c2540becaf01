// Mapping for two solvers with the same points: water as a field is computed on the soil's particles. A point takes the
// values of its partner in the other solver unchanged (docs/decisions/0023-field-on-moving-soil.md).
#pragma once

#include "coupler/mapping.hpp"

namespace poretwin::coupling {

/// Partners are found once, at the first positions, and kept however the points move. Points of the solid without a
/// partner, behind rough walls, take the values of the nearest point of the fluid. If a point of the fluid has no
/// partner, the points are not the same, and fields are mapped as between clouds; conservative amounts always are.
std::unique_ptr<SpatialMapping> make_paired_mapping(int dimension);

}  // namespace poretwin::coupling
