// The outline of all soil of a case in 2D, in straight parts.
#pragma once

#include "common/case/case.hpp"
#include "common/geometry/pieces.hpp"

#include <span>
#include <vector>

namespace poretwin {

struct OutlinePart {
  Piece piece;           ///< walked with the soil on its left
  std::size_t soil = 0;  ///< index in the case's list
  std::size_t line = 0;  ///< number of the straight line on which it lies; sides that continue each other share one
};

/// Distance up to which a place counts as lying on a line. In spacings of the points.
inline constexpr double beside_outline = 1e-3;

/// The sides of all soils beyond which no other soil lies, divided where corners of soils and ends of the pieces of
/// `faces` lie on them. Of two soils that overlap, the part of either that lies in the other is left out. spacing [m]:
/// of the points in the soil.
std::vector<OutlinePart> soil_outline(const Case& scene, double spacing, std::span<const Face> faces);

/// The parts of the soil's outline that are open to free water: those along no wall for water, no water face and no
/// rain.
std::vector<Piece> open_outline(const Case& scene, double spacing);

/// The pieces of a wall that bound something other than soil: without those that have soil on their left.
std::vector<Piece> beside_no_soil(const Case& scene, double spacing, const Face& wall);

}  // namespace poretwin
