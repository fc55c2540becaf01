// Surfaces from files: triangle meshes (STL, OBJ, PLY) and terrains (ESRI ASCII grid, points x y z on a grid).
#pragma once

#include "common/geometry/triangle_mesh.hpp"

#include <filesystem>
#include <string_view>

namespace poretwin {

/// The surface in a file's text. The format follows from the file's ending and, for STL and PLY, from its beginning.
/// Polygons are divided into triangles. Throws CaseError with what was expected and found, and in which line or facet.
Triangles parse_mesh(std::string_view text, std::string_view ending);

/// The closed body between a terrain and the elevation `bottom` [m]. Heights lie on a grid: at its points (.xyz) or in
/// the centres of its cells (.asc); two triangles join each four neighbours. Throws the same errors as parse_mesh.
Triangles parse_terrain(std::string_view text, std::string_view ending, double bottom);

}  // namespace poretwin
