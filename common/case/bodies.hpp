// Makes bodies from the case's shapes: reads files, makes surfaces, places and examines them.
#pragma once

#include "common/case/case.hpp"
#include "common/case/keys.hpp"

namespace poretwin {

/// Makes Shape::solid of every shape that needs one (3D) and places the other shapes. Throws CaseError with file, line,
/// key and place for a surface that cannot bound a body: an open surface, one that is turned against itself or crosses
/// itself, or a body whose size is out of proportion to the particles.
void make_solids(Case& scene, const Places& places);

}  // namespace poretwin
