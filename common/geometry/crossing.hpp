// Finds lines of straight pieces that cross themselves.
#pragma once

#include "common/case/case.hpp"

#include <cstddef>
#include <optional>
#include <vector>

namespace poretwin {

/// Two pieces of one line, each identified by the number of its first point (from 0), and their crossing [m].
struct Crossing {
  std::size_t first, second;
  Point3 at;
};

/// The first crossing of a line of points with itself (2D). `closed`: the last point is joined to the first. Pieces
/// that only touch, or coincide as the two sides of the bridge to a hole do, do not cross.
std::optional<Crossing> self_crossing(const std::vector<Point3>& points, bool closed);

}  // namespace poretwin
