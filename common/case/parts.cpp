#include "common/case/parts.hpp"

#include "common/case/amounts.hpp"
#include "common/geometry/shapes.hpp"
#include "common/geometry/soil_outline.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace poretwin {
namespace {

constexpr std::array kinds_in_ground{
    std::string_view("front"),         std::string_view("discharge"),      std::string_view("exit_height"),
    std::string_view("exit_gradient"), std::string_view("pressure_force"), std::string_view("heave"),
    std::string_view("level"),         std::string_view("passed_volume"),  std::string_view("basin")};
constexpr std::array kinds_in_free_water{
    std::string_view("max_speed"), std::string_view("kinetic_energy"), std::string_view("potential_energy"),
    std::string_view("energy"),    std::string_view("momentum"),       std::string_view("extent"),
    std::string_view("spread"),    std::string_view("particles"),      std::string_view("min_pressure")};
constexpr std::array kinds_of_both{std::string_view("volume"), std::string_view("balance"),
                                   std::string_view("infiltration")};

template <class Words>
bool is_among(const Words& words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// Whether a region of water lies in soil; check_both() refuses regions that lie in it in part only.
bool region_in_soil(const Case& scene, const Shape& region) {
  const auto places = places_in(region, scene.fluid.particle_spacing, scene.general.dimension);
  return !places.empty() && soil_at(scene, places.front());
}

/// Lines through pieces in a row, each of which begins where the last one ends.
std::vector<Face> joined(const std::vector<Piece>& pieces, double near) {
  std::vector<Face> lines;
  for (const auto& piece : pieces) {
    if (lines.empty() || (lines.back().points.back() - piece.a).norm() > near) lines.emplace_back().points = {piece.a};
    lines.back().points.push_back(piece.b);
  }
  // The outline is closed: its last part may go on where the first begins.
  if (lines.size() > 1 && (lines.back().points.back() - lines.front().points.front()).norm() <= near) {
    auto& first = lines.front().points;
    first.insert(first.begin(), lines.back().points.begin(), lines.back().points.end() - 1);
    lines.pop_back();
  }
  return lines;
}

void keep_gauges(const Case& scene, GaugePlace place, Case& part) {
  std::erase_if(part.gauges, [&](const Gauge& gauge) {
    const GaugePlace at = place_of(scene, gauge);
    return at != place && !(at == GaugePlace::all && gauge.kind == "volume");
  });
}

}  // namespace

bool has_free_water(const Case& scene) {
  return std::any_of(scene.fluid.regions.begin(), scene.fluid.regions.end(), [&](const Shape& region) {
    const auto places = places_in(region, scene.fluid.particle_spacing, scene.general.dimension);
    return std::any_of(places.begin(), places.end(), [&](const Point3& x) { return !soil_at(scene, x); });
  });
}

GaugePlace place_of(const Case& scene, const Gauge& gauge) {
  if (is_among(kinds_of_both, gauge.kind)) return GaugePlace::all;
  if (is_among(kinds_in_free_water, gauge.kind)) return GaugePlace::free_water;
  const auto inside =
      std::count_if(gauge.points.begin(), gauge.points.end(), [&](const Point3& x) { return soil_at(scene, x); });
  if (is_among(kinds_in_ground, gauge.kind)) return GaugePlace::ground;
  if (gauge.kind != "point") return GaugePlace::nowhere;
  if (inside == 0) return GaugePlace::free_water;
  return inside == static_cast<std::ptrdiff_t>(gauge.points.size()) ? GaugePlace::ground : GaugePlace::astride;
}

Case ground_part(const Case& scene) {
  Case part = scene;
  part.fluid.representation = FluidCase::Representation::field;
  std::erase_if(part.fluid.regions, [&](const Shape& region) { return !region_in_soil(scene, region); });
  for (const auto& piece : open_outline(scene, scene.fluid.particle_spacing)) {
    WaterFace face;
    face.name = "free water";
    face.face.points = {piece.a, piece.b};
    face.free_water = true;
    part.water_faces.push_back(std::move(face));
  }
  keep_gauges(scene, GaugePlace::ground, part);
  return part;
}

Case free_part(const Case& scene) {
  const double dx = scene.fluid.particle_spacing, near = beside_outline * dx;
  Case part = scene;
  part.fluid.representation = FluidCase::Representation::particles;
  std::erase_if(part.fluid.regions, [&](const Shape& region) { return region_in_soil(scene, region); });
  part.soils.clear();
  part.wells.clear();
  part.water_faces.clear();
  std::vector<Wall> more;
  for (auto& wall : part.walls) {
    if (wall.water == Wall::ForWater::none || wall.face.points.empty()) continue;
    const auto lines = joined(beside_no_soil(scene, dx, wall.face), near);
    for (std::size_t i = 1; i < lines.size(); ++i) {
      more.push_back(wall);
      more.back().face = lines[i];
    }
    if (lines.empty())
      wall.water = Wall::ForWater::none;
    else
      wall.face = lines[0];
  }
  part.walls.insert(part.walls.end(), more.begin(), more.end());
  for (auto& line : joined(open_outline(scene, dx), near)) {
    // A wall has the water on its left.
    std::reverse(line.points.begin(), line.points.end());
    Wall bed;
    bed.name = "bed";
    bed.face = std::move(line);
    part.walls.push_back(std::move(bed));
  }
  keep_gauges(scene, GaugePlace::free_water, part);
  return part;
}

}  // namespace poretwin
