// Edges at which walls by `point` and `normal` meet. Their images are made wall by wall, in the order of the case
// (make_images), and fill the space behind an edge once only if it has a right angle, or is that of a sector of
// 90 / 2^k degrees whose walls stand in the right order (docs/theory/walls.md).
#pragma once

#include "common/case/case.hpp"
#include "common/case/keys.hpp"

#include <string>
#include <vector>

namespace poretwin {

/// Throws CaseError where soil or water lies at an edge behind which images leave a gap or overlap, and where soil on a
/// rough base lies in a narrower sector than the base holds.
void check_wall_edges(const Case& scene, const Places& places);

/// Warnings of such edges that soil or water could reach.
std::vector<std::string> doubtful_wall_edges(const Case& scene, const Places& places);

}  // namespace poretwin
