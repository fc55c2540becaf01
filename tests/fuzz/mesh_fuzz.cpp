// Any bytes as a mesh or terrain, of the format that the first of them chooses: either a CaseError or a surface.
#include "common/core/error.hpp"
#include "common/geometry/mesh_file.hpp"

#include <array>
#include <cstdint>
#include <string_view>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  constexpr std::array<std::string_view, 5> endings{".stl", ".obj", ".ply", ".asc", ".xyz"};
  const std::string_view ending = endings[data[0] % endings.size()],
                         text(reinterpret_cast<const char*>(data) + 1, size - 1);
  try {
    const auto surface = ending == ".asc" || ending == ".xyz" ? poretwin::parse_terrain(text, ending, -1.0)
                                                              : poretwin::parse_mesh(text, ending);
    static_cast<void>(poretwin::TriangleMesh(surface).contains(poretwin::Vec<3>::Zero()));
  } catch (const poretwin::CaseError&) {
    // refused with its reason
  }
  return 0;
}
