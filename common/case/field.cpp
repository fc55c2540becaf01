#include "common/case/field.hpp"

#include "common/case/amounts.hpp"
#include "common/case/complaints.hpp"
#include "common/case/parts.hpp"
#include "common/geometry/extent.hpp"
#include "common/geometry/pieces.hpp"
#include "common/geometry/shapes.hpp"
#include "common/geometry/soil_outline.hpp"
#include "common/geometry/soil_surface.hpp"
#include "common/media/anisotropy.hpp"
#include "common/media/retention_law.hpp"
#include "common/media/seepage.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace poretwin {
namespace {

/// Kinds of gauges that a field of pore water can have.
constexpr std::array field_kinds{
    std::string_view("point"),       std::string_view("front"),          std::string_view("discharge"),
    std::string_view("exit_height"), std::string_view("exit_gradient"),  std::string_view("volume"),
    std::string_view("balance"),     std::string_view("level"),          std::string_view("passed_volume"),
    std::string_view("particles"),   std::string_view("infiltration"),   std::string_view("evaporation"),
    std::string_view("runoff"),      std::string_view("pressure_force"), std::string_view("heave"),
    std::string_view("basin")};
/// Kinds of gauges that only a field has, and water particles do not: of rain, of a basin.
constexpr std::array rain_kinds{std::string_view("infiltration"), std::string_view("evaporation"),
                                std::string_view("runoff")};
constexpr std::string_view basin_kind = "basin";

/// Largest distance from a plane, in spacings, at which a place on the soil's surface counts as on the plane (3D).
constexpr double beside_plane = 1e-3;
/// Least cosine between the vertical and the outward normal of a surface on which rain can fall.
constexpr double least_upwards = 1e-9;

template <class Words>
bool has(const Words& words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

class FieldChecks : Complaints {
 public:
  FieldChecks(const Case& scene, const Places& places)
      : Complaints(scene, places), dimension_(scene.general.dimension) {
    const double g = scene.general.gravity.norm();
    if (g > 0.0) up_ = -scene.general.gravity / g;
  }

  void of_particles() const {
    constexpr const char* reason = "belongs to a field; expected fluid.representation = \"field\"";
    for (std::size_t i = 0; i < scene_.soils.size(); ++i)
      if (scene_.soils[i].retention) fail(fmt::format("soil[{}].retention", i), reason);
    for (std::size_t i = 0; i < scene_.soils.size(); ++i) beds_of_particles(i);
    if (!scene_.rains.empty()) fail("rain[0]", reason);
    for (std::size_t i = 0; i < scene_.water_faces.size(); ++i) {
      const WaterFace& f = scene_.water_faces[i];
      if (f.face.within) fail(fmt::format("water_face[{}].within", i), reason);
      if (f.basin_rain) fail(fmt::format("water_face[{}].basin_rain", i), reason);
      if (f.spill_level) fail(fmt::format("water_face[{}].spill_level", i), reason);
    }
    if (!scene_.wells.empty()) fail("well[0]", reason);
    for (const char* key : {"fluid.initial_pressure_head", "fluid.initial_water_table"})
      if (given(key)) fail(key, reason);
    for (std::size_t i = 0; i < scene_.gauges.size(); ++i) {
      const Gauge& g = scene_.gauges[i];
      const std::string key = fmt::format("gauge[{}]", i);
      if (has(rain_kinds, g.kind) || g.kind == basin_kind)
        fail(key + ".kind", fmt::format("\"{}\" {}", g.kind, reason));
      if (given(key + ".pressure_head")) fail(key + ".pressure_head", reason);
      if (g.kind == "point" && (g.quantity == "water_content" || g.quantity == "borne_pressure"))
        fail(key + ".quantity", reason);
    }
  }

  void of_field() const {
    scene();
    keys_of_particles();
    soils();
    no_narrow_gaps();
    initial();
    water_faces();
    rains();
    if (dimension_ == 3) in_space();
    wells();
    gauges();
  }

  /// Whether the case has a key that only a field has.
  [[nodiscard]] bool asks_for_field() const {
    if (std::any_of(scene_.soils.begin(), scene_.soils.end(), porous::is_anisotropic)) return true;
    try {
      of_particles();
    } catch (const CaseError&) {
      return true;
    }
    return false;
  }
  /// What in the case needs water with inertia, or soil that may slide; empty where nothing does.
  [[nodiscard]] std::string asks_for_inertia() const {
    if (!scene_.deformable()) return {};
    if (scene_.can_yield()) return "the soil can yield, and a slide has inertia";
    if (!scene_.solid.initial_velocity.isZero() || scene_.solid.initial_wave != 0.0)
      return "the soil has a velocity at time zero";
    for (std::size_t i = 0; i < scene_.loads.size(); ++i)
      if (scene_.loads[i].factor) return fmt::format("load[{}] changes in time, which may raise waves", i);
    return {};
  }

 private:
  void scene() const {
    if (scene_.soils.empty()) fail("soil", "a field lives on points of soil; expected a [[soil]], found none");
    if (up_.isZero() && asks_for_heads())
      fail("case.gravity",
           "heads need gravity, found a vector of length zero; without it a field has prescribed "
           "pressures only");
    if (!scene_.general.periodic.empty()) periodic();
    if (scene_.deformable()) moving_soil();
    if (up_.isZero()) full_soil();
    walls();
  }

  /// Checks of periodic sides, at which the points on either side must face each other.
  void periodic() const {
    const General& g = scene_.general;
    const double dx = scene_.fluid.particle_spacing, slack = 1e-6 * dx;
    if (static_cast<int>(g.periodic.size()) >= dimension_)
      fail("case.periodic",
           fmt::format("a field needs a side at which its soil ends; expected {} axes at most, found {}",
                       dimension_ - 1, g.periodic.size()));
    if (scene_.can_yield())
      fail(
          "case.periodic",
          "soil that can yield carries its points through periodic sides, where a field loses them; expected soil that "
          "is rigid or elastic, or fluid.representation = \"particles\"");
    const bool moves = scene_.deformable();
    const std::string table = moves ? "solid" : "fluid";
    if ((moves ? scene_.solid.jitter : scene_.fluid.jitter) != 0.0)
      fail(table + ".jitter", "with periodic sides a field's points on either side must face each other; expected 0");
    for (const int axis : g.periodic) {
      const double low = g.domain_min[axis], high = g.domain_max[axis];
      const char name = "xyz"[axis];
      if ((moves ? scene_.solid.offset : scene_.fluid.offset)[axis] != 0.5)
        fail(table + ".offset",
             fmt::format("with periodic sides the points on either side must lie half a spacing from it; expected 0.5 "
                         "along {}, found {}",
                         name, (moves ? scene_.solid.offset : scene_.fluid.offset)[axis]));
      for (std::size_t s = 0; s < scene_.soils.size(); ++s) {
        const Soil& soil = scene_.soils[s];
        const std::string key = fmt::format("soil[{}]", s);
        if (is_turned(soil.shape) || is_packed(soil.shape))
          fail(key + ".shape",
               fmt::format("with periodic sides the points lie on a lattice along the axes; expected {}",
                           dimension_ == 2 ? "a box or a polygon that is no turned rectangle" : "a box"));
        const auto [from, to] = extent(soil.shape, Point3::Unit(axis), dimension_);
        if (from < low - slack || to > high + slack)
          fail(key + ".shape",
               fmt::format("lies from {} to {} m along {}, partly outside the periodic box from {} to {} m; expected "
                           "soil within it",
                           from, to, name, low, high));
        const bool at_low = from<low + slack, at_high = to> high - slack;
        if (at_low != at_high) fits_not(key, name, at_low ? low : high);
        if (at_low) same_on_both_sides(s, axis);
        if (porous::is_anisotropic(soil) && porous::across_beds(scene_, soil).cwiseAbs().maxCoeff() < 1.0 - 1e-9)
          fail(key + ".bedding_normal",
               fmt::format("with periodic sides beds must lie along the axes; found the normal {}",
                           shown(porous::across_beds(scene_, soil))));
      }
      no_faces_on_side(axis);
      if (std::abs(up_[axis]) > 1e-12) no_heads_along(name);
    }
  }
  [[noreturn]] void fits_not(const std::string& key, char axis, double side) const {
    fail(key + ".shape", fmt::format("ends on the periodic side {} = {} m, and does not continue on the opposite side; "
                                     "expected the same soil on both",
                                     axis, side));
  }
  /// Refuses a soil whose ends on two opposite periodic sides differ.
  void same_on_both_sides(std::size_t s, int axis) const {
    const General& g = scene_.general;
    if (dimension_ == 3) return;  // a box ends equally on both
    const double dx = scene_.fluid.particle_spacing, inside = 1e-3 * dx;
    const Shape& shape = scene_.soils[s].shape;
    const auto [from, to] = extent(shape, Point3::Unit(1 - axis), 2);
    const int places = std::max(4, static_cast<int>(std::ceil(4.0 * (to - from) / dx)));
    for (int k = 0; k < places; ++k) {
      Point3 x = Point3::Zero();
      x[1 - axis] = from + (k + 0.5) / places * (to - from);
      x[axis] = g.domain_min[axis] + inside;
      const bool one = contains(shape, x, 2);
      x[axis] = g.domain_max[axis] - inside;
      if (one != contains(shape, x, 2))
        fits_not(fmt::format("soil[{}]", s), "xyz"[axis], one ? g.domain_min[axis] : g.domain_max[axis]);
    }
  }
  void no_faces_on_side(int axis) const {
    const General& g = scene_.general;
    const double slack = 1e-6 * scene_.fluid.particle_spacing;
    const auto look = [&](const Face& face, const std::string& key) {
      const auto on_a_side = [&](const Point3& a, const Point3& b) {
        return std::ranges::any_of(std::array{g.domain_min[axis], g.domain_max[axis]}, [&](double side) {
          return std::abs(a[axis] - side) < slack && std::abs(b[axis] - side) < slack;
        });
      };
      bool there = face.points.empty() && !face.normal.isZero() && on_a_side(face.point, face.point) &&
                   std::abs(face.normal.normalized()[axis]) > 1.0 - 1e-9;
      for (const auto& piece : pieces_of(face)) there = there || on_a_side(piece.a, piece.b);
      if (there)
        fail(key, fmt::format("lies on a side at which the case repeats itself along {} (case.periodic); expected it "
                              "elsewhere, or a case that is not periodic",
                              "xyz"[axis]));
    };
    for (std::size_t i = 0; i < scene_.water_faces.size(); ++i)
      look(scene_.water_faces[i].face, fmt::format("water_face[{}]", i));
    for (std::size_t i = 0; i < scene_.rains.size(); ++i) look(scene_.rains[i].face, fmt::format("rain[{}]", i));
  }
  /// Refuses levels and heads where elevation changes along a periodic axis: they would not be periodic, but pressures
  /// are.
  void no_heads_along(char axis) const {
    const std::string reason = fmt::format(
        "is measured along gravity, which has a component along the periodic axis {}, so that it would jump at the "
        "sides; "
        "expected a pressure",
        axis);
    for (std::size_t i = 0; i < scene_.water_faces.size(); ++i)
      for (const char* key : {"head", "basin_area"})
        if (given(fmt::format("water_face[{}].{}", i, key))) fail(fmt::format("water_face[{}].{}", i, key), reason);
    if (!scene_.wells.empty()) fail("well[0]", reason);
    if (scene_.fluid.initial_water_table) fail("fluid.initial_water_table", reason);
    if (scene_.fluid.initial_pressure_head && scene_.fluid.initial_pressure_head->knots.size() > 1)
      fail("fluid.initial_pressure_head", reason + " head that is the same everywhere");
  }

  /// Refuses walls that would have no effect: a field is bounded by its soil, not by walls.
  void walls() const {
    const double dx = scene_.fluid.particle_spacing;
    for (std::size_t w = 0; w < scene_.walls.size(); ++w) {
      const Wall& wall = scene_.walls[w];
      if (wall.water == Wall::ForWater::none || !wall.face.points.empty()) continue;
      const std::string key = fmt::format("wall[{}]", w);
      if (wall.shape)
        fail(key + ".shape",
             "a field does not see walls with a shape; expected the soil drawn without the body of the wall (a "
             "[[soil.without]] with its shape)");
      const Point3 normal = wall.face.normal.normalized();
      for (std::size_t s = 0; s < scene_.soils.size(); ++s)
        for (const auto& x : places_in(scene_.soils[s].shape, scene_.fluid.particle_spacing, dimension_))
          if (normal.dot(x - wall.face.point) < -1e-6 * dx)
            fail(key, fmt::format("{} lies behind it, for example at {} m: a wall by 'point' and 'normal' is a plane "
                                  "without end, at which a field does not stop; expected all soil on the side to "
                                  "which the normal points",
                                  named("soil", s, scene_.soils[s].name), shown(x)));
    }
  }

  [[nodiscard]] bool asks_for_heads() const {
    const auto& faces = scene_.water_faces;
    return !scene_.deformable() || scene_.fluid.initial_pressure_head || scene_.fluid.initial_water_table ||
           !scene_.rains.empty() || !sharp(scene_.soils.front()) ||
           std::any_of(faces.begin(), faces.end(),
                       [](const WaterFace& f) { return f.head || f.outlet || f.basin_area; });
  }

  /// Refuses dry soil in a case without gravity, in which the water within a partly full cell would have no position.
  void full_soil() const {
    for (std::size_t i = 0; i < scene_.soils.size(); ++i)
      for (const auto& x : places_in(scene_.soils[i].shape, scene_.fluid.particle_spacing, dimension_))
        if (std::none_of(scene_.fluid.regions.begin(), scene_.fluid.regions.end(),
                         [&](const Shape& region) { return contains(region, x, dimension_); }))
          fail(fmt::format("soil[{}]", i),
               fmt::format("is dry, for example at {} m; without gravity expected a [[fluid.region]] over all of it",
                           shown(x)));
  }

  /// Checks of a field in moving soil, where the points of the field are the soil's particles.
  void moving_soil() const {
    if (scene_.fluid.particle_spacing != scene_.solid.particle_spacing)
      fail("fluid.particle_spacing",
           fmt::format("a field's points are the soil's particles; expected solid.particle_spacing, {} m, found {} m",
                       scene_.solid.particle_spacing, scene_.fluid.particle_spacing));
    for (const char* key : {"fluid.offset", "fluid.jitter", "fluid.seed"})
      if (given(key)) fail(key, "a field's points are the soil's particles; expected the key under [solid]");
    if (scene_.coupling.scheme == CouplingCase::Scheme::parallel)
      fail("coupling.scheme",
           "a field and its soil take turns; expected \"iterated\" or \"serial\", found \"parallel\"");
    // The solid solver finds the water behind the soil's surface only along faces that have ends.
    for (std::size_t i = 0; i < scene_.water_faces.size(); ++i)
      if (const WaterFace& f = scene_.water_faces[i];
          f.face.points.empty() && (f.head || f.basin_area || (f.pressure && highest(*f.pressure) > 0.0))) {
        if (dimension_ == 2)
          fail(fmt::format("water_face[{}].point", i),
               "a field in soil that moves needs the ends of a face with water behind it; expected 'points'");
        if (f.face.normal.isZero())
          fail(fmt::format("water_face[{}].within", i),
               "in soil that moves a face with water behind it is flat; expected 'point' and 'normal' besides");
      }
    if (dimension_ == 3 && scene_.can_yield())
      fail("solid.model",
           "with a field in 3D soil is rigid or elastic so far, found soil that can yield; expected \"elastic\" or "
           "\"rigid\", or fluid.representation = \"particles\"");
    if (scene_.can_yield() && !scene_.rains.empty())
      fail("rain[0]",
           "on soil that can yield is not supported by a field; expected solid.model = \"rigid\" or \"elastic\"");
    if (scene_.solid.initial_wave != 0.0)
      fail("solid.initial_wave", "a field has no inertia; expected fluid.representation = \"particles\"");
  }

  void keys_of_particles() const {
    for (const char* key : {"fluid.scheme", "fluid.sweeps", "fluid.pressure_tolerance", "fluid.initial_velocity",
                            "fluid.initial_strain", "fluid.initial_wave", "fluid.initial_vortices", "fluid.drag",
                            "fluid.drag_form", "fluid.skeleton_response", "case.central_force"})
      if (given(key)) fail(key, "belongs to fluid.representation = \"particles\", found with \"field\"");
    if (scene_.fluid.scheme != FluidCase::Scheme::projection)
      fail("case.scheme", "\"paper\" is a scheme of particles, found with fluid.representation = \"field\"");
    for (std::size_t i = 0; i < scene_.soils.size(); ++i)
      for (const char* key : {"suction_head", "initial_saturation"})
        if (given(fmt::format("soil[{}].{}", i, key)) &&
            (std::string_view(key) == "suction_head" || scene_.soils[i].retention))
          fail(fmt::format("soil[{}].{}", i, key),
               "belongs to soil without capillarity, or to fluid.representation = \"particles\"; a field has a "
               "[soil.retention] instead");
  }

  [[nodiscard]] bool sharp(const Soil& soil) const { return porous::retention_law(soil).curve == nullptr; }

  void soils() const {
    for (std::size_t i = 0; i < scene_.soils.size(); ++i) {
      const Soil& soil = scene_.soils[i];
      const std::string key = fmt::format("soil[{}]", i);
      if (dimension_ == 2 && soil.shape.kind == Shape::Kind::ball)
        fail(key + ".shape", "a field needs straight sides so far; expected a box or a polygon, found a ball");
      if (porous::seepage_at(scene_, soil, soil.porosity).quadratic != 0.0)
        fail(key + ".seepage_law",
             fmt::format("a field flows by Darcy's law so far; expected a linear law, found \"{}\"",
                         soil.seepage_law->name));
      if (sharp(soil) != sharp(scene_.soils.front()))
        fail(key + ".retention",
             fmt::format("{} has {}capillarity and soil[0] has {}; expected all soils of a case with it or all without",
                         named("soil", i, soil.name), sharp(soil) ? "no " : "", sharp(soil) ? "some" : "none"));
      if (soil.retention) retention(soil, *soil.retention, key + ".retention");
      beds(soil, key);
    }
  }

  /// Whether a soil has beds; refuses keys of beds that are not complete.
  [[nodiscard]] bool has_beds(const Soil& soil, const std::string& key) const {
    if (!porous::is_anisotropic(soil)) {
      if (!soil.bedding_normal.isZero())
        fail(key + ".bedding_normal",
             "has no effect without 'anisotropy', the conductivity along the beds over that "
             "across them; expected both or neither");
      return false;
    }
    if (porous::across_beds(scene_, soil).isZero())
      fail(key + ".bedding_normal", "without gravity expected the direction across the beds, found none");
    return true;
  }
  /// Refuses beds with water as particles where the flow was not shown to be right (docs/theory/seepage.md).
  void beds_of_particles(std::size_t i) const {
    const Soil& soil = scene_.soils[i];
    const std::string key = fmt::format("soil[{}]", i), ratio = key + ".anisotropy";
    if (!has_beds(soil, key)) return;
    constexpr const char* or_field = "or fluid.representation = \"field\"";
    if (dimension_ == 3)
      fail(ratio, "with water as particles beds are computed in 2D only; expected fluid.representation = \"field\"");
    if (scene_.deformable())
      fail(ratio,
           fmt::format("with water as particles soil in beds must be at rest; expected solid.model = \"rigid\", {}",
                       or_field));
    if (!porous::same_anisotropy(scene_))
      fail(ratio,
           fmt::format("with water as particles all soils must have the same beds; expected the same 'anisotropy' "
                       "and 'bedding_normal' in all soils, {}",
                       or_field));
    const porous::Seepage law = porous::seepage_at(scene_, soil, soil.porosity);
    if (law.quadratic != 0.0)
      fail(key + ".seepage_law", fmt::format("in beds water flows by Darcy's law; expected a linear law, found \"{}\"",
                                             soil.seepage_law->name));
    if (!scene_.general.periodic.empty())
      fail("case.periodic", fmt::format("with water as particles in beds expected no periodic sides, {}", or_field));
    if (scene_.fluid.scheme != FluidCase::Scheme::projection)
      fail("fluid.scheme", "in soil with beds the pressure is solved for; expected \"projection\"");
    if (!scene_.fluid.drag || scene_.fluid.drag_form != FluidCase::DragForm::pointwise)
      fail(scene_.fluid.drag ? "fluid.drag_form" : "fluid.drag",
           "in soil with beds the drag at each particle is that of Darcy's law; expected this key to be absent");
    const bool inlet = std::any_of(scene_.water_faces.begin(), scene_.water_faces.end(),
                                   [&](const WaterFace& face) { return is_inlet(scene_, face); });
    if (inlet || has_free_water(scene_))
      fail(ratio,
           "with water as particles in beds expected water in soil only, and heads at the soil's faces; found free "
           "water, for which expected fluid.representation = \"both\"");
    for (std::size_t f = 0; f < scene_.water_faces.size(); ++f) face_of_beds(scene_.water_faces[f], f);
    const double highest = highest_water();
    for (const auto& piece : open_outline(scene_, scene_.fluid.particle_spacing))
      if (const Point3& low = up_.dot(piece.a) < up_.dot(piece.b) ? piece.a : piece.b; up_.dot(low) < highest)
        fail(ratio,
             fmt::format("with water as particles in beds no water may leave the soil but through a face; at {} m "
                         "the soil's surface has neither wall nor face, and water can stand as high; expected a "
                         "[[water_face]] with 'outlet = true' or a wall there, {}",
                         shown(low), or_field));
    // The water has no inertia there. Drag must stop it as fast as where seepage is quasi-static in other soil.
    constexpr double held_within = 0.1;  // of sqrt(spacing / g), as in fluid_solver/numerics/exchange.hpp
    const double g = scene_.general.gravity.norm(), n = soil.porosity * (1.0 - soil.initial_saturation);
    if (g > 0.0 && law.conductivity > held_within * std::sqrt(scene_.fluid.particle_spacing * g) * n)
      fail(key + ".hydraulic_conductivity",
           fmt::format("in such coarse soil the water's inertia matters, which it does not have in beds; expected "
                       "{:.2g} m/s or less at this particle spacing, {}",
                       held_within * std::sqrt(scene_.fluid.particle_spacing * g) * n, or_field));
  }

  /// Refuses a face along which the head changes: the flow beside it was not shown to be right in beds.
  void face_of_beds(const WaterFace& face, std::size_t f) const {
    const std::string key = fmt::format("water_face[{}]", f);
    if (face.wave_amplitude)
      fail(key + ".wave_amplitude", "with water as particles in beds expected a head or a uniform pressure");
    const auto& line = face.face.points;
    if (face.pressure && !line.empty() &&
        std::any_of(line.begin(), line.end(), [&](const Point3& x) { return std::abs(up_.dot(x - line[0])) > 1e-9; }))
      fail(key + ".pressure",
           "with water as particles in beds expected a 'head', or a level face: along this one the head changes");
  }
  /// Elevation [m] up to which water can stand in the soil.
  [[nodiscard]] double highest_water() const {
    if (up_.isZero()) return HUGE_VAL;
    double highest = -HUGE_VAL;
    for (const auto& region : scene_.fluid.regions) highest = std::max(highest, extent(region, up_, dimension_).second);
    for (const auto& face : scene_.water_faces) {
      if (face.head)
        for (const auto& [time, head] : face.head->knots) highest = std::max(highest, head);
      if (face.pressure)
        for (const auto& [time, pressure] : face.pressure->knots)
          for (const auto& x : face.face.points)
            highest = std::max(highest, up_.dot(x) + pressure / porous::specific_weight(scene_));
      if (face.discharge || face.basin_area || face.face.points.empty()) return HUGE_VAL;  // known only in the run
    }
    double suction = 0.0;
    for (const auto& soil : scene_.soils) suction = std::max(suction, soil.suction_head);
    return highest + suction;
  }

  void beds(const Soil& soil, const std::string& key) const {
    if (!has_beds(soil, key)) return;
    const Point3 normal = porous::across_beds(scene_, soil);
    if (porous::same_anisotropy(scene_)) return;
    // With several anisotropies the flow between two points is exact in other directions in each soil.
    const std::string otherwise =
        "where soils differ in their anisotropy the points must lie on a lattice along the beds; expected all soils "
        "with the same 'anisotropy' and 'bedding_normal', or ";
    constexpr double along_axis = 1.0 - 1e-9;
    if (normal.cwiseAbs().maxCoeff() < along_axis)
      fail(key + ".bedding_normal",
           fmt::format("{}a normal along a coordinate axis, found {}", otherwise, shown(normal)));
    const bool moves = scene_.deformable();
    if ((moves ? scene_.solid.jitter : scene_.fluid.jitter) != 0.0)
      fail(key + ".anisotropy", fmt::format("{}no jitter", otherwise));
    if (scene_.can_yield()) fail(key + ".anisotropy", otherwise + "soil that does not yield, and stays on its lattice");
    for (std::size_t s = 0; s < scene_.soils.size(); ++s) {
      const Shape& shape = scene_.soils[s].shape;
      if (is_turned(shape) || (moves && dimension_ == 3 && is_packed(shape)))
        fail(fmt::format("soil[{}].shape", s), otherwise + "boxes along the axes");
    }
  }
  /// Whether the lattice in a shape is turned against the axes.
  [[nodiscard]] bool is_turned(const Shape& shape) const {
    if (dimension_ == 3) return shape.solid && !is_packed(shape);
    return turned_rectangle(shape).has_value();
  }

  void retention(const Soil& soil, const RetentionCase& r, const std::string& key) const {
    if (!(r.residual_water_content < soil.porosity))
      fail(key + ".residual_water_content",
           fmt::format("expected less than the saturated water content, which is the porosity of {}, found {}",
                       soil.porosity, r.residual_water_content));
    const auto& mine = porous::retention_law(soil);
    for (const auto& p : mine.parameters) {
      const double value = r.numbers.at(p.key);
      if (p.needed && !(value > p.above))
        fail(key + "." + p.key, fmt::format("the law \"{}\" needs it, a number above {}{}, found {}", mine.name,
                                            p.above, p.unit.empty() ? "" : " " + p.unit,
                                            given(key + "." + p.key) ? fmt::format("{}", value) : "none"));
    }
    for (const auto& law : porous::retention_laws())
      for (const auto& p : law.parameters)
        if (given(key + "." + p.key) && std::none_of(mine.parameters.begin(), mine.parameters.end(),
                                                     [&](const auto& own) { return own.key == p.key; }))
          fail(key + "." + p.key,
               fmt::format("belongs to retention.model = \"{}\", found with \"{}\"", law.name, mine.name));
    for (const auto& [name, rows] : {std::pair{"saturation", &r.saturation}, {"permeability", &r.permeability}}) {
      if (mine.takes_tables && !*rows)
        fail(key + "." + name,
             fmt::format("the law \"{}\" needs it, a table [[psi, value], ...], found none", mine.name));
      if (!mine.takes_tables && *rows) fail(key + "." + name, "belongs to retention.model = \"table\"");
      if (*rows) rising(**rows, key + "." + name);
    }
    if (r.saturation) drains(*r.saturation, key + ".saturation");
    if (r.permeability) no_jump(*r.permeability, key + ".permeability");
  }

  /// Requires a table whose values are above zero, rise from row to row, and reach 1 at a pressure head of at most
  /// zero.
  void rising(const Series& table, const std::string& key) const {
    const auto& rows = table.knots;
    if (rows.size() < 2) fail(key, fmt::format("expected two rows or more, found {}", rows.size()));
    if (rows.back().first > 0.0)
      fail(key, fmt::format("expected pressure heads of zero or below, found {} m", rows.back().first));
    if (!(rows.front().second > 0.0))
      fail(key, fmt::format("expected values above zero, found {}", rows.front().second));
    for (std::size_t i = 1; i < rows.size(); ++i)
      if (!(rows[i].second > rows[i - 1].second))
        fail(key, fmt::format("expected values that rise with the pressure head, found {} at {} m after {} at {} m",
                              rows[i].second, rows[i].first, rows[i - 1].second, rows[i - 1].first));
    if (rows.back().second != 1.0)
      fail(key, fmt::format("expected 1 in the last row, where the soil is full, found {}", rows.back().second));
  }

  /// Refuses permeabilities that jump: within less than half a spacing by a factor of 2 from one row to the next, or of
  /// 5 over several rows. The flow between two points, one on each side of the jump, then depends so strongly on the
  /// wetter one that the steps in time shrink without end.
  void no_jump(const Series& table, const std::string& key) const {
    constexpr double by_one_row = 2.0, by_several = 5.0, narrow = 0.5;  // spacings
    const double least = narrow * scene_.fluid.particle_spacing;
    const auto& rows = table.knots;
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (std::size_t j = i + 1; j < rows.size() && rows[j].first - rows[i].first < least * (1.0 - 1e-9); ++j) {
        const auto& [from, low] = rows[i];
        const auto& [to, high] = rows[j];
        if (high < (j == i + 1 ? by_one_row : by_several) * low) continue;
        fail(key, fmt::format(
                      "rises from {} at {} m to {} at {} m, {:g} times within {:.2g} m of suction, which points {} m "
                      "apart do not resolve: expected {} half a spacing apart, {:g} m, or a smaller "
                      "fluid.particle_spacing",
                      low, from, high, to, high / low, to - from, scene_.fluid.particle_spacing,
                      j == i + 1 ? "rows at least" : "such a rise over at least", least));
      }
  }

  /// Requires that the first two rows of saturation differ: below them it continues as the power of the suction that
  /// connects them, and must halve within 100 doublings of the suction.
  void drains(const Series& table, const std::string& key) const {
    const auto& [psi, value] = table.knots[0];
    const auto& [next, above] = table.knots[1];
    constexpr double least = 0.01;
    if (!(next < 0.0))
      fail(key, fmt::format("expected two rows or more below a pressure head of zero, found one, {} m", psi));
    if (!(std::log(above / value) > least * std::log(psi / next)))
      fail(key,
           fmt::format("rises from {} at {} m to {} at {} m only, so that no suction drains the soil: expected an "
                       "effective saturation near zero in the first row; water that stays is residual_water_content",
                       value, psi, above, next));
  }

  /// Refuses narrow gaps between soils, which are cut-offs to a field, and most likely drawn by mistake: a coordinate
  /// with a wrong last digit.
  void no_narrow_gaps() const {
    constexpr double narrow = 0.05;  // spacings
    const double dx = scene_.fluid.particle_spacing;
    const auto look = [&](std::size_t soil, const Point3& x, const Point3& outwards) {
      for (std::size_t s = 0; s < scene_.soils.size(); ++s)
        if (s != soil && contains(scene_.soils[s].shape, x + narrow * dx * outwards, dimension_))
          fail(fmt::format("soil[{}]", std::max(s, soil)),
               fmt::format("a gap of less than {:.2g} m is left to {} at {} m, through which a field passes no water: "
                           "expected soils that touch, or a wider gap for a cut-off",
                           narrow * dx, named("soil", std::min(s, soil), scene_.soils[std::min(s, soil)].name),
                           shown(x)));
    };
    if (dimension_ == 2) {
      for (const OutlinePart& part : soil_outline(scene_, dx, {}))
        for (const auto& x : places_along(part.piece, dx)) look(part.soil, x, -part.piece.left());
      return;
    }
    if (scene_.soils.size() < 2) return;
    const SoilSurface surface(scene_, dx);
    for (const auto& place : surface.places(dx)) look(surface.soil_of(place), place.at, place.outwards);
  }

  void initial() const {
    const auto& f = scene_.fluid;
    if (f.initial_pressure_head && f.initial_water_table)
      fail("fluid.initial_water_table", "expected it or 'initial_pressure_head', found both");
    if (!sharp(scene_.soils.front()) && !f.initial_pressure_head && !f.initial_water_table)
      fail("fluid.initial_water_table",
           "soil with a retention curve is never without water: expected it or 'initial_pressure_head', found none");
    for (std::size_t i = 0; i < f.regions.size(); ++i)
      for (const auto& x : places_in(f.regions[i], f.particle_spacing, dimension_))
        if (!soil_at(scene_, x))
          fail(fmt::format("fluid.region[{}]", i),
               fmt::format("is free water, for example at {} m; expected water in soil only, or fluid.representation = "
                           "\"both\" or \"particles\"",
                           shown(x)));
  }

  /// Whether soil lies in front of a face. Refuses a piece that is drawn along the soil's surface, but beside it: a
  /// field meets its faces on the surface only.
  [[nodiscard]] bool touches_soil(const Face& face, const std::string& key) const {
    const double dx = scene_.fluid.particle_spacing, near = 0.25 * dx, on_it = 2.0 * beside_outline * dx;
    bool any = false;
    for (const auto& piece : pieces_of(face)) {
      int along = 0, on = 0;
      Point3 beside = piece.a;
      for (const auto& x : places_along(piece, 0.5 * dx)) {
        if (!soil_at(scene_, x + near * piece.left())) continue;
        ++along;
        if (soil_at(scene_, x + on_it * piece.left()) && !soil_at(scene_, x - on_it * piece.left()))
          ++on;
        else
          beside = x;
      }
      if (2 * on < along)
        fail(
            key + ".points",
            fmt::format("the line from {} to {} m does not lie on the soil's surface, for example at {} m; expected it "
                        "within {:.2g} m of the surface: a field would not meet it",
                        shown(piece.a), shown(piece.b), shown(beside), beside_outline * dx));
      any = any || along > 0;
    }
    return any;
  }

  void water_faces() const {
    for (std::size_t i = 0; i < scene_.water_faces.size(); ++i) {
      const WaterFace& f = scene_.water_faces[i];
      const std::string key = fmt::format("water_face[{}]", i);
      if (f.discharge && !f.basin_area)
        fail(key + ".discharge",
             "a field has no inlet; expected 'head', 'pressure' or 'outlet', or 'basin_area' with it: a basin");
      if (f.wave_amplitude)
        fail(key + ".wave_amplitude",
             "a field has no waves before it; expected 'head', 'pressure', 'outlet' or a basin");
      if (dimension_ == 2 && f.face.within) fail(key + ".within", "belongs to dimension = 3, found dimension = 2");
      if (!f.face.points.empty() && !touches_soil(f.face, key))
        fail(key + ".points", "no soil lies before the face; expected one along a side of the soil, on its left");
      if (f.basin_area) basin(f, key);
      if (!f.head || f.basin_area || f.face.points.empty()) continue;
      const auto crest = crest_of(scene_, f);
      if (crest && highest(*f.head) > crest->elevation + 1e-9)
        fail(key + ".head",
             fmt::format("the water behind the face rises to {} m and would run over its upper end at {} m; expected a "
                         "lower head, 'pressure' where the face is level and nothing can run over its end, or "
                         "fluid.representation = \"particles\"",
                         highest(*f.head), crest->elevation));
    }
  }

  /// Checks of a basin in 2D and 3D; further ones of the face's place: basin_before().
  void basin(const WaterFace& f, const std::string& key) const {
    if (scene_.can_yield())
      fail(
          key + ".basin_area",
          "in soil that can yield the basin's area would change with the soil; expected soil that is rigid or elastic, "
          "or 'head'");
    if (f.head && f.head->knots.size() > 1)
      fail(key + ".head",
           "of a basin it is the level at time zero, from which the balance leads on; expected one "
           "number, found a table");
    if (dimension_ == 3) return;
    if (f.face.points.empty())
      fail(key + ".point", "a plane has no ends, between which a basin lies; expected 'points', found 'point'");
    double lowest = HUGE_VAL;
    for (const auto& x : f.face.points) lowest = std::min(lowest, up_.dot(x));
    const auto crest = crest_of(scene_, f);
    basin_before(f, key, lowest, crest ? crest->elevation : HUGE_VAL);
  }
  /// Checks a basin's bottom and spill level against the lowest place of its face and against the elevation [m] at
  /// which its water would run over the face's upper end.
  void basin_before(const WaterFace& f, const std::string& key, double lowest, double crest) const {
    const double dx = scene_.fluid.particle_spacing, slack = 1e-6 * dx, bottom = f.basin_area->knots.front().first;
    if (bottom > lowest + slack)
      fail(
          key + ".basin_area",
          fmt::format("begins at {} m, above the lowest place of the face at {} m, so that the empty basin would stand "
                      "before the soil; expected a table from there or from below, [[z, area], ..]",
                      bottom, lowest));
    if (!(crest < HUGE_VAL) || (f.spill_level && *f.spill_level <= crest + slack)) return;
    fail(
        key + ".spill_level",
        fmt::format("the basin's water could rise above the face's upper end at {} m and run over it; expected a level "
                    "of at most that, up to which the basin holds water, found {}; or a [[wall]] that rises from that "
                    "end, or fluid.representation = \"particles\"",
                    crest, f.spill_level ? fmt::format("{} m", *f.spill_level) : "none"));
  }

  static double highest(const Series& series) {
    double most = -HUGE_VAL;
    for (const auto& knot : series.knots) most = std::max(most, knot.second);
    return most;
  }

  void rains() const {
    for (std::size_t i = 0; i < scene_.rains.size(); ++i) {
      const Rain& rain = scene_.rains[i];
      const std::string key = fmt::format("rain[{}]", i);
      if (sharp(scene_.soils.front()))
        fail(key,
             "rain makes soil wet without filling it, for which it needs a retention curve; expected a "
             "[soil.retention] with another model than \"sharp\"");
      if (dimension_ == 2 && rain.face.within) fail(key + ".within", "belongs to dimension = 3, found dimension = 2");
      if (dimension_ == 3) continue;
      if (rain.face.points.empty())
        fail(key + ".point", "expected 'points', a line along the soil's surface; found a plane");
      if (!touches_soil(rain.face, key))
        fail(key + ".points",
             "no soil lies under the rain; expected a line along the soil's surface, with the soil on its left");
      for (const auto& piece : pieces_of(rain.face)) {
        if (!(up_.dot(piece.left()) < -1e-9))
          fail(key + ".points",
               fmt::format("from {} to {} m the soil does not lie below the line; expected a line with the "
                           "soil on its left and below it",
                           shown(piece.a), shown(piece.b)));
        for (const auto& x : places_along(piece, 0.5 * scene_.fluid.particle_spacing)) {
          under_water(x, key);
          for (std::size_t w = 0; w < scene_.walls.size(); ++w)
            if (scene_.walls[w].water != Wall::ForWater::none && lies_on(scene_.walls[w].face, x))
              fail(key + ".points",
                   fmt::format("falls on {} at {} m, which lets no water through; set water = \"none\" "
                               "there or move one of them",
                               named("wall", w, scene_.walls[w].name), shown(x)));
          for (std::size_t j = 0; j < i; ++j)
            if (lies_on(scene_.rains[j].face, x))
              fail(key + ".points",
                   fmt::format("falls where rain[{}] does, at {} m; expected one rain at each place", j, shown(x)));
        }
      }
    }
  }
  [[nodiscard]] bool lies_on(const Face& face, const Point3& x) const {
    const double slack = 1e-3 * scene_.fluid.particle_spacing;
    for (const auto& piece : pieces_of(face))
      if (distance_from(piece, x) < slack) return true;
    return false;
  }
  /// Checks of faces and rains in 3D, at places of the soil's surface a spacing apart.
  void in_space() const {
    const double dx = scene_.fluid.particle_spacing;
    if (!(dx > 0.0) || (scene_.water_faces.empty() && scene_.rains.empty())) return;
    const SoilSurface surface(scene_, dx);
    const auto places = surface.places(dx);
    const auto along = [&](const Face& face) {
      std::vector<SoilSurface::Place> found;
      for (const auto& place : places)
        if (lies_along(face, place, beside_plane * dx)) found.push_back(place);
      return found;
    };
    for (std::size_t i = 0; i < scene_.water_faces.size(); ++i) {
      const WaterFace& f = scene_.water_faces[i];
      const std::string key = fmt::format("water_face[{}]", i);
      const auto found = along(f.face);
      if (found.empty()) fail(key, fmt::format("is nowhere on the soil's surface; {}", expected_of(f.face)));
      for (const auto& place : found)
        for (std::size_t w = 0; w < scene_.walls.size(); ++w)
          if (scene_.walls[w].water != Wall::ForWater::none && !scene_.walls[w].face.normal.isZero() &&
              lies_along(scene_.walls[w].face, place, beside_plane * dx))
            fail(key, fmt::format("lies on {} at {} m, which lets no water through; set water = \"none\" there or move "
                                  "one of them",
                                  named("wall", w, scene_.walls[w].name), shown(place.at)));
      if (f.head || f.basin_area) below_its_top(surface, f, key, found);
    }
    std::vector<std::vector<SoilSurface::Place>> rained;
    for (std::size_t i = 0; i < scene_.rains.size(); ++i) {
      const std::string key = fmt::format("rain[{}]", i);
      auto found = along(scene_.rains[i].face);
      std::erase_if(found, [&](const auto& place) { return !(up_.dot(place.outwards) > least_upwards); });
      if (found.empty())
        fail(key,
             fmt::format("falls nowhere on soil's surface that looks upwards; {}", expected_of(scene_.rains[i].face)));
      for (const auto& place : found) rain_in_space(i, key, place);
    }
  }
  static std::string expected_of(const Face& face) {
    return face.normal.isZero() ? "expected a shape that contains a part of the surface"
                                : "expected a plane on which the surface lies, with a normal into the soil";
  }
  void rain_in_space(std::size_t i, const std::string& key, const SoilSurface::Place& place) const {
    const double slack = beside_plane * scene_.fluid.particle_spacing;
    for (std::size_t f = 0; f < scene_.water_faces.size(); ++f)
      if (lies_along(scene_.water_faces[f].face, place, slack)) under_water(f, place.at, key);
    for (std::size_t w = 0; w < scene_.walls.size(); ++w)
      if (scene_.walls[w].water != Wall::ForWater::none && !scene_.walls[w].face.normal.isZero() &&
          lies_along(scene_.walls[w].face, place, slack))
        fail(key,
             fmt::format("falls on {} at {} m, which lets no water through; set water = \"none\" there or move one "
                         "of them",
                         named("wall", w, scene_.walls[w].name), shown(place.at)));
    for (std::size_t j = 0; j < i; ++j)
      if (lies_along(scene_.rains[j].face, place, slack))
        fail(key,
             fmt::format("falls where rain[{}] does, at {} m; expected one rain at each place", j, shown(place.at)));
  }
  /// Refuses a head above the upper end of a face, over which the water would flow. Allowed where a wall closes the
  /// top, as on the roof of a confined layer, and on level faces, such as the bed of a pond.
  void below_its_top(const SoilSurface& surface, const WaterFace& f, const std::string& key,
                     const std::vector<SoilSurface::Place>& places) const {
    const double dx = scene_.fluid.particle_spacing;
    double low = HUGE_VAL, sampled = -HUGE_VAL;
    for (const auto& place : places) {
      low = std::min(low, up_.dot(place.at));
      sampled = std::max(sampled, up_.dot(place.at));
    }
    double lowest = low;  // m, of the face; `low` is that of the places on it
    for (const auto& place : places)
      if (f.basin_area && up_.dot(place.at) < low + dx)
        lowest = std::min(lowest, up_.dot(upper_end(surface, f.face, place, -up_, 2.0 * dx, beside_plane * dx)));
    Point3 top = Point3::Zero();
    double high = -HUGE_VAL;
    for (const auto& place : places) {
      if (up_.dot(place.at) < sampled - dx) continue;
      const Point3 end = upper_end(surface, f.face, place, up_, 2.0 * dx, beside_plane * dx);
      if (up_.dot(end) <= high) continue;
      high = up_.dot(end);
      top = end;
    }
    const bool level = high - low < beside_plane * dx;
    if (!f.basin_area && (level || highest(*f.head) <= high + 2.0 * beside_plane * dx)) return;
    constexpr double beside_wall = 0.1;  // spacings; a face given by a shape may end a little below the wall
    const bool lid = std::any_of(scene_.walls.begin(), scene_.walls.end(), [&](const Wall& wall) {
      return wall.water != Wall::ForWater::none && !wall.face.normal.isZero() &&
             std::abs(wall.face.normal.normalized().dot(top - wall.face.point)) < beside_wall * dx;
    });
    if (f.basin_area) return basin_before(f, key, lowest, level || lid ? HUGE_VAL : high + 2.0 * beside_plane * dx);
    if (!lid)
      fail(key + ".head",
           fmt::format("the water behind the face rises to {} m and would run over its upper end at {} m; expected a "
                       "lower head, or a [[wall]] on the soil's top, such as the roof of a confined layer",
                       highest(*f.head), high));
  }

  void under_water(std::size_t f, const Point3& x, const std::string& key) const {
    const WaterFace& face = scene_.water_faces[f];
    if (face.pressure)
      fail(key, fmt::format("falls on {} at {} m, where the pressure is prescribed; expected rain beside it",
                            named("water_face", f, face.name), shown(x)));
    if (face.basin_area)
      fail(key, fmt::format("falls on {} at {} m, a basin, to which water from the face flows; expected rain beside it "
                            "and 'basin_rain' for its water",
                            named("water_face", f, face.name), shown(x)));
    if (face.head && highest(*face.head) > up_.dot(x + scene_.general.origin))
      fail(key,
           fmt::format("falls on {} at {} m, which comes to lie under its water, up to {} m; expected rain above the "
                       "highest level only",
                       named("water_face", f, face.name), shown(x), highest(*face.head)));
  }
  void under_water(const Point3& x, const std::string& key) const {
    for (std::size_t f = 0; f < scene_.water_faces.size(); ++f)
      if (lies_on(scene_.water_faces[f].face, x)) under_water(f, x, key);
  }

  void wells() const {
    for (std::size_t i = 0; i < scene_.wells.size(); ++i) {
      const Well& well = scene_.wells[i];
      const std::string key = fmt::format("well[{}]", i);
      const double dx = scene_.fluid.particle_spacing;
      const std::size_t ends = dimension_ == 3 ? 2 : 1;
      if (well.points.size() != ends)
        fail(key + ".points", fmt::format("expected {}, found {} points",
                                          ends == 2 ? "the 2 ends of the screen"
                                                    : "1 point, the centre of a drain across "
                                                      "the section (2D)",
                                          well.points.size()));
      if (well.discharge.has_value() == well.head.has_value())
        fail(key, fmt::format("expected either 'discharge' or 'head', found {}", well.head ? "both" : "neither"));
      if (up_.isZero()) fail(key, "a well needs gravity, by which its level acts; found case.gravity of length zero");
      for (std::size_t s = 0; s < scene_.soils.size(); ++s) {
        const Soil& soil = scene_.soils[s];
        if (!porous::is_anisotropic(soil)) continue;
        const Point3 axis = well.points.back() - well.points.front(), normal = porous::across_beds(scene_, soil);
        constexpr double parallel = 1e-6;
        if (dimension_ == 2 || !(axis.cross(normal).norm() < parallel * axis.norm()))
          fail(
              key + ".points",
              fmt::format("in anisotropic soil a well must stand across the beds (3D), so that water flows to it along "
                          "them from all sides; expected a screen in the direction {}, found soil[{}].anisotropy = {}",
                          shown(normal), s, soil.anisotropy));
      }
      if (scene_.can_yield())
        fail(key, "in soil that can yield a well would have to move with it; expected soil that is rigid or elastic");
      constexpr double widest = 0.15, nearest = 3.0, shortest = 3.0;  // spacings
      if (well.radius > widest * dx)
        fail(key + ".radius",
             fmt::format(
                 "expected {:g} m at most, {:g} particle spacings, found {} m: a wider well is drawn as a hole in "
                 "the soil with a [[water_face]] along it, or needs a larger fluid.particle_spacing",
                 widest * dx, widest, well.radius));
      for (std::size_t j = 0; j < scene_.water_faces.size() && !well.name.empty(); ++j)
        if (scene_.water_faces[j].name == well.name)
          fail(key + ".name",
               fmt::format("expected a name of its own, found \"{}\", which water_face[{}] has", well.name, j));
      own_name(scene_.wells, i, "well");
      apart_from_others(i, key);
      const Point3 a = well.points.front(), b = well.points.back();
      const double length = (b - a).norm();
      if (dimension_ == 3 && length < shortest * dx * (1.0 - 1e-9))
        fail(
            key + ".points",
            fmt::format("the screen is {:.4g} m long; expected {:g} particle spacings or more, {:.4g} m: near the ends "
                        "of a shorter one water does not flow across its axis, as the well's resistance presumes",
                        length, shortest, shortest * dx));
      Point3 u = Point3::UnitX(), v = Point3::UnitY();
      if (dimension_ == 3) {
        u = (b - a).unitOrthogonal();
        v = (b - a).cross(u) / length;
      }
      const int parts = dimension_ == 3 ? std::max(1, static_cast<int>(std::ceil(length / dx))) : 1;
      constexpr int directions = 12;
      for (int k = 0; k < parts; ++k) {
        const Point3 x = a + (k + 0.5) / parts * (b - a);
        if (!soil_at(scene_, x))
          fail(key + ".points",
               fmt::format("the screen lies outside the soil at {} m; expected all of it in soil", shown(x)));
        for (int d = 0; d < directions; ++d) {
          const double angle = 2.0 * std::numbers::pi * d / directions;
          const Point3 aside = x + nearest * dx * (std::cos(angle) * u + std::sin(angle) * v);
          if (!soil_at(scene_, aside))
            fail(key + ".points",
                 fmt::format(
                     "the soil ends at {} m, nearer than {:g} particle spacings, {:.4g} m, from the screen at {} m; "
                     "expected a well farther inside, or a smaller fluid.particle_spacing",
                     shown(aside), nearest, nearest * dx, shown(x)));
        }
      }
    }
  }

  /// Refuses a well so near to an earlier one that both would act at the same points, as if they stood in one place.
  void apart_from_others(std::size_t i, const std::string& key) const {
    constexpr double nearest = 2.0;  // spacings
    const double dx = scene_.fluid.particle_spacing;
    const Well& well = scene_.wells[i];
    for (std::size_t j = 0; j < i; ++j) {
      const Well& other = scene_.wells[j];
      const auto [distance, place] = nearest_of(well, other);
      if (distance < nearest * dx * (1.0 - 1e-9))
        fail(key + ".points", fmt::format("stands {:.4g} m from {} at {} m; expected {:g} particle spacings or more, "
                                          "{:.4g} m: nearer wells act at the same points, as if they were in one place",
                                          distance, named("well", j, other.name), shown(place), nearest, nearest * dx));
    }
  }
  /// Least distance between the screens of two wells [m], and where on the first one it is found.
  [[nodiscard]] std::pair<double, Point3> nearest_of(const Well& well, const Well& other) const {
    const Point3 a = well.points.front(), way = well.points.back() - a;
    const int parts = std::max(1, static_cast<int>(std::ceil(way.norm() / (0.25 * scene_.fluid.particle_spacing))));
    std::pair<double, Point3> nearest{HUGE_VAL, a};
    for (int k = 0; k <= parts; ++k) {
      const Point3 x = a + static_cast<double>(k) / parts * way;
      const Point3 b = other.points.front(), along = other.points.back() - b;
      const double length = along.squaredNorm();
      const double share = length > 0.0 ? std::clamp(along.dot(x - b) / length, 0.0, 1.0) : 0.0;
      if (const double distance = (x - b - share * along).norm(); distance < nearest.first) nearest = {distance, x};
    }
    return nearest;
  }

  void gauges() const {
    for (std::size_t i = 0; i < scene_.gauges.size(); ++i) {
      const Gauge& g = scene_.gauges[i];
      const std::string key = fmt::format("gauge[{}]", i);
      if (g.phase == "solid") continue;
      if (!has(field_kinds, g.kind)) {
        std::string list;
        for (const auto kind : field_kinds) list += fmt::format("{}\"{}\"", list.empty() ? "" : ", ", kind);
        fail(key + ".kind", fmt::format("a field has no \"{}\"; expected one of {}", g.kind, list));
      }
      if (g.kind == "point" && g.quantity.starts_with("velocity"))
        fail(key + ".quantity",
             "a field has no velocity of its water; expected a pressure, a head, \"degree_of_saturation\", "
             "\"water_content\" or \"borne_pressure\"");
      if (g.kind == "discharge" && !g.quantity.empty() && !g.points.empty())
        fail(key + ".quantity", "expected the name of a face or the 'points' of a line, found both");
      if (has(rain_kinds, g.kind) && !g.quantity.empty() &&
          std::none_of(scene_.rains.begin(), scene_.rains.end(),
                       [&](const Rain& rain) { return rain.name == g.quantity; }))
        fail(key + ".quantity", fmt::format("expected the name of a [[rain]], found \"{}\"", g.quantity));
    }
  }

  Point3 up_ = Point3::Zero();
  int dimension_;
};

}  // namespace

void check_field(const Case& scene, const Places& places) {
  const FieldChecks checks(scene, places);
  if (scene.is_field())
    checks.of_field();
  else
    checks.of_particles();
}

void choose_representation(Case& scene, const Places& places) {
  using Representation = FluidCase::Representation;
  auto& chosen = scene.fluid.representation;
  chosen = Representation::field;
  const FieldChecks checks(scene, places);
  if (scene.soils.empty()) {
    scene.representation_chosen = "particles: there is no soil";
    chosen = Representation::particles;
  } else if (checks.asks_for_field() && has_free_water(scene)) {
    scene.representation_chosen = "both: the case has keys that only a field has, and free water";
    chosen = Representation::both;
  } else if (checks.asks_for_field()) {
    scene.representation_chosen = "field: the case has keys that only a field has";
  } else if (const std::string inertia = checks.asks_for_inertia(); !inertia.empty()) {
    scene.representation_chosen = "particles: " + inertia;
    chosen = Representation::particles;
  } else {
    try {
      checks.of_field();
      scene.representation_chosen = "field: all water stays in soil, and nothing asks for inertia";
    } catch (const CaseError& error) {
      scene.representation_chosen =
          fmt::format("particles: a field does not have what the case asks for: {}", error.what());
      chosen = Representation::particles;
    }
  }
}

}  // namespace poretwin
