#include "common/case/both.hpp"

#include "common/case/amounts.hpp"
#include "common/case/complaints.hpp"
#include "common/case/parts.hpp"
#include "common/geometry/pieces.hpp"
#include "common/geometry/shapes.hpp"
#include "common/geometry/soil_outline.hpp"

#include <algorithm>
#include <array>

namespace poretwin {
namespace {

constexpr std::array keys_of_free_water{
    std::string_view("fluid.pressure_tolerance"), std::string_view("fluid.initial_velocity"),
    std::string_view("fluid.initial_strain"), std::string_view("fluid.initial_wave")};
constexpr std::array keys_of_ground{std::string_view("fluid.initial_pressure_head"),
                                    std::string_view("fluid.initial_water_table")};

class BothChecks : Complaints {
 public:
  using Complaints::Complaints;

  void all() const {
    if (scene_.soils.empty())
      fail("soil", with("a field lives in soil: expected a [[soil]], found none; without soil, \"particles\""));
    if (scene_.general.dimension != 2)
      fail("case.dimension", with("the soil's surface is followed in 2D only so far; expected dimension = 2"));
    if (scene_.deformable()) fail("solid.model", with("the soil is rigid so far; expected solid.model = \"rigid\""));
    if (scene_.general.gravity.isZero())
      fail("case.gravity", with("free water lies on the soil by its weight; found none"));
    if (!scene_.general.periodic.empty()) fail("case.periodic", with("periodic sides are not supported so far"));
    if (!scene_.rains.empty()) fail("rain[0]", with("rain is not supported so far"));
    for (const char* key : {"fluid.scheme", "fluid.sweeps", "fluid.drag", "fluid.drag_form", "fluid.skeleton_response",
                            "fluid.initial_vortices", "case.central_force"})
      if (given(key)) fail(key, with("has no effect or is not supported"));
    if (scene_.fluid.scheme != FluidCase::Scheme::projection) fail("case.scheme", with("\"paper\" is not supported"));
    regions();
    faces();
    surface();
    gauges();
  }

 private:
  static std::string with(const std::string& message) { return "with fluid.representation = \"both\": " + message; }

  void regions() const {
    if (!has_free_water(scene_))
      fail("fluid", with("there is no free water; expected a [[fluid.region]] outside the soil, or \"field\""));
    for (std::size_t i = 0; i < scene_.fluid.regions.size(); ++i) {
      const auto places = places_in(scene_.fluid.regions[i], scene_.fluid.particle_spacing, 2);
      const auto wet = std::find_if(places.begin(), places.end(), [&](const Point3&x) { return soil_at(scene_, x); }),
                 free = std::find_if(places.begin(), places.end(), [&](const Point3&x) { return !soil_at(scene_, x); });
      if (wet != places.end() && free != places.end())
        fail(fmt::format("fluid.region[{}]", i),
             with(fmt::format("lies in soil at {} m and outside it at {} m; expected one region for free water, which "
                              "ends at the soil, and another, or 'initial_water_table', for water in the soil",
                              shown(*wet), shown(*free))));
    }
  }

  void faces() const {
    for (std::size_t i = 0; i < scene_.water_faces.size(); ++i)
      if (is_inlet(scene_, scene_.water_faces[i]))
        fail(fmt::format("water_face[{}]", i),
             with("no soil lies before the face, and faces of free water are not supported so far; expected a face "
                  "along the soil, or the reservoir drawn as a [[fluid.region]]"));
  }

  void surface() const {
    const auto open = open_outline(scene_, scene_.fluid.particle_spacing);
    if (open.empty())
      fail("soil[0]", with("walls, faces and the edge of the drawing leave no part of the soil's surface open to free "
                           "water; expected a part without any of them"));
    const Point3 up = -scene_.general.gravity.normalized();
    for (const auto& piece : open)
      if (constexpr double overhang = 0.01; up.dot(piece.left()) > overhang)
        fail("soil[0]",
             with(fmt::format("the soil's surface from {} to {} m looks down and is open, so that its water would drip "
                              "out; expected a [[wall]] along the base of the soil, or a [[water_face]]",
                              shown(piece.a), shown(piece.b))));
    constexpr std::size_t most = 29;  // numbers of boundaries that the water's solver has
    if (const std::size_t count = free_part(scene_).walls.size(); count > most)
      fail("wall",
           with(fmt::format("{} walls and open parts of the soil's surface; expected {} at most", count, most)));
  }

  void gauges() const {
    for (std::size_t i = 0; i < scene_.gauges.size(); ++i) {
      const Gauge& g = scene_.gauges[i];
      const std::string key = fmt::format("gauge[{}]", i);
      const GaugePlace place = place_of(scene_, g);
      if (place == GaugePlace::nowhere) fail(key + ".kind", with(fmt::format("\"{}\" cannot be read", g.kind)));
      if (place == GaugePlace::astride)
        fail(key + ".points", with("some of the points lie in soil and others do not; expected two gauges"));
      if (place == GaugePlace::ground && !g.points.empty() && g.kind != "exit_height" && g.kind != "exit_gradient" &&
          std::none_of(g.points.begin(), g.points.end(), [&](const Point3& x) { return soil_at(scene_, x); }))
        fail(key + ".points",
             with(fmt::format("\"{}\" is read in the soil, and none of the points lies in it", g.kind)));
      if (g.kind == "infiltration" && !g.quantity.empty())
        fail(key + ".quantity", with("all that the soil takes from the free water is summed; expected no 'quantity'"));
      if (g.kind != "point") continue;
      const bool of_field = g.quantity == "water_content" || g.quantity == "borne_pressure";
      if (place == GaugePlace::free_water && of_field) fail(key + ".quantity", with("belongs to places in the soil"));
      if (place == GaugePlace::ground && g.quantity.starts_with("velocity"))
        fail(key + ".quantity", with("water in the soil has no velocity; expected a pressure, a head or a content"));
    }
  }
};

template <class Keys>
Places without(const Places& places, const Keys& keys) {
  Places rest = places;
  for (const auto key : keys)
    if (const auto found = rest.find(key); found != rest.end()) rest.erase(found);
  return rest;
}

}  // namespace

void check_both(const Case& scene, const Places& places) { BothChecks(scene, places).all(); }

Places places_of_ground(const Places& places) { return without(places, keys_of_free_water); }
Places places_of_free_water(const Places& places) { return without(places, keys_of_ground); }

}  // namespace poretwin
