// From the case's shapes to bodies: files read, surfaces made, placed and examined.
#pragma once

#include "common/case/case.hpp"
#include "common/case/keys.hpp"

namespace poretwin {

/// Makes Shape::solid of every shape that needs one (3D) and places the others. Throws CaseError with file, line, key
/// and place for what cannot be a body: a surface that is open, turned against itself or crosses itself, a size out of
/// proportion to the particles.
void make_solids(Case& scene, const Places& places);

}  // namespace poretwin
