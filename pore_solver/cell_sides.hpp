// The sides of a Voronoi cell as voro++ gives them.
#pragma once

#include "common/case/case.hpp"

#include <voro++/voro++.hh>

#include <vector>

namespace poretwin::pore {

/// Calls take(beyond, corners) for each side of a cell. beyond: what lies behind the side (index of a point, or the
/// number with which the cell was cut). corners: relative to the cell's point, in the cell's unit of length.
template <class Take>
void for_each_side(voro::voronoicell_neighbor& cell, Take&& take) {
  std::vector<int> beyond, indices;
  std::vector<double> vertices;
  cell.neighbors(beyond);
  cell.face_vertices(indices);
  cell.vertices(vertices);
  std::vector<Point3> corners;
  std::size_t at = 0;
  for (const int next : beyond) {
    corners.clear();
    for (int left = indices[at++]; left > 0; --left) {
      const auto v = 3 * static_cast<std::size_t>(indices[at++]);
      corners.emplace_back(vertices[v], vertices[v + 1], vertices[v + 2]);
    }
    take(next, corners);
  }
}

}  // namespace poretwin::pore
