#include "common/case/check.hpp"

#include "common/case/amounts.hpp"
#include "common/case/basin.hpp"
#include "common/case/both.hpp"
#include "common/case/complaints.hpp"
#include "common/case/field.hpp"
#include "common/case/gauge_kinds.hpp"
#include "common/case/gauge_quantities.hpp"
#include "common/case/materials.hpp"
#include "common/case/parts.hpp"
#include "common/case/plates.hpp"
#include "common/case/soil_walls.hpp"
#include "common/case/unsupported.hpp"
#include "common/case/wall_edges.hpp"
#include "common/geometry/crossing.hpp"
#include "common/geometry/enclosure.hpp"
#include "common/geometry/flat_section.hpp"
#include "common/geometry/overlap.hpp"
#include "common/geometry/shapes.hpp"
#include "common/geometry/surfaces.hpp"
#include "common/media/erosion_law.hpp"
#include "common/media/seepage.hpp"

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace poretwin {
namespace {

constexpr std::array<std::string_view, 2> phases{"fluid", "solid"};
constexpr std::array line_kinds{std::string_view("front"),          std::string_view("discharge"),
                                std::string_view("exit_height"),    std::string_view("exit_gradient"),
                                std::string_view("pressure_force"), std::string_view("heave")};

class Checker : Complaints {
 public:
  using Complaints::Complaints;

  void all() const {
    if (scene_.is_both()) return parts();
    general();
    check_field(scene_, places_);
    amounts();
    soils();
    fluid_regions();
    faces();
    walls();
    check_plates(scene_, places_);
    nothing_behind_planes();
    check_wall_edges(scene_, places_);
    shaped_walls();
    soil_beside_shapes();
    soils_are_supported();
    if (scene_.deformable()) check_soil_walls(scene_, places_);
    nothing_on_periodic_sides();
    pore_pressures();
    if (scene_.has_water()) sides();
    gauges();
    // The other checks are for water particles: a field stays within its soil, so that no water can run out.
    if (scene_.is_field()) return check_loads(scene_, places_);
    if (scene_.has_water()) enclosure();
    check_supported(scene_, places_);
  }

 private:
  /// Checks what belongs to the case as a whole, and then each of its two parts as a case of its own. Gauges are
  /// checked here, where they have their places in the file.
  void parts() const {
    general();
    check_both(scene_, places_);
    amounts();
    gauges();
    const auto check_part = [](Case part, const Places& places) {
      part.gauges.clear();
      if (part.has_water()) Checker(part, places).all();
    };
    check_part(ground_part(scene_), places_of_ground(places_));
    check_part(free_part(scene_), places_of_free_water(places_));
  }

  void general() const {
    const auto& g = scene_.general;
    for (const int axis : g.periodic)
      if (!(g.domain_max[axis] > g.domain_min[axis]))
        fail("case.periodic",
             fmt::format(
                 "the periodic axis \"{}\" needs case.domain_min below case.domain_max along it, found {} and {}",
                 "xyz"[axis], g.domain_min[axis], g.domain_max[axis]));
    if (scene_.deformable() && scene_.soils.empty())
      fail("solid.model",
           "a soil skeleton is asked for but there is no [[soil]]; set solid.model = \"rigid\" for water alone");
    if (!scene_.has_water() && !scene_.deformable())
      fail("fluid", "there is no water: expected a [[fluid.region]] or a [[water_face]]");
    if (scene_.has_water() && !(scene_.fluid.particle_spacing > 0.0))
      fail("fluid.particle_spacing", "there is water: expected a length > 0 m, found none");
    if (scene_.deformable() && !(scene_.solid.particle_spacing > 0.0))
      fail("solid.particle_spacing", "expected a length > 0 m, found none");
  }

  /// Refuses runs that no present machine could store, before any particle is made.
  void amounts() const {
    const Amounts a = estimate(scene_);
    const int dimension = scene_.general.dimension;
    constexpr double most_particles = 1e9, most_bytes = 1e12, most_rows = 1e9;
    const auto too_many = [&](const char* section, const char* what, double count, double spacing) {
      if (!(count > most_particles)) return;
      fail(fmt::format("{}.particle_spacing", section),
           fmt::format(
               "{:.2g} {} particles at a spacing of {} m: expected {:g} at most; give a larger spacing ({:.2g} m "
               "for a million particles), or lengths in metres",
               count, what, spacing, most_particles, spacing * std::pow(count / 1e6, 1.0 / dimension)));
    };
    too_many("fluid", "water", a.fluid_full, scene_.fluid.particle_spacing);
    too_many("solid", "soil", a.solid, scene_.solid.particle_spacing);
    if (a.frame_bytes > most_bytes)
      fail(
          "output.interval",
          fmt::format("{:.3g} frames of {:.3g} particles would take {:.2g} TB: expected {:g} TB at most; give a longer "
                      "interval (s), 0 for the first and the last frame only",
                      a.frames, a.fluid + a.solid, a.frame_bytes / 1e12, most_bytes / 1e12));
    if (a.gauge_rows > most_rows)
      fail("output.gauge_interval",
           fmt::format("{:.3g} gauge readings: expected {:g} at most; give a longer interval (s)", a.gauge_rows,
                       most_rows));
  }

  /// Refuses a shape much thinner than a spacing, in which the lattice would have no row of particles.
  void extent(const Shape& s, const char* what, const std::string& key, double spacing) const {
    const auto [lower, upper] = bounds(s);
    for (int d = 0; d < scene_.general.dimension; ++d)
      if (upper[d] - lower[d] < 0.5 * spacing)
        fail(key, fmt::format("no particle fits: the {} measures {} m along {}, the particle spacing is {} m", what,
                              upper[d] - lower[d], "xyz"[d], spacing));
  }

  void shape(const Shape& s, const std::string& key, double spacing) const {
    const int dimension = scene_.general.dimension;
    if (s.solid) {
      extent(s, "shape", key, spacing);
      if (spacing > 0.0 && measure(s, dimension) < 0.5 * std::pow(spacing, 3))
        fail(key, fmt::format("no particle fits: the shape's volume is {:.3g} m3, the particle spacing is {} m",
                              measure(s, dimension), spacing));
      return;
    }
    if (s.kind == Shape::Kind::box) {
      if (given(key + ".points"))
        fail(key + ".points", "a box takes 'min' and 'max'; 'points' belongs to shape = \"polygon\"");
      for (int d = 0; d < dimension; ++d) {
        if (!(s.max[d] > s.min[d]))
          fail(key + ".max",
               fmt::format("expected every coordinate above that of 'min' {}, found {}", shown(s.min), shown(s.max)));
      }
      return extent(s, "box", key, spacing);
    }
    if (s.kind == Shape::Kind::ball) {
      if (s.radius < 0.5 * spacing)
        fail(key + ".radius", fmt::format("no particle fits: the ball's radius is {} m, the particle spacing is {} m",
                                          s.radius, spacing));
      return;
    }
    if (given(key + ".min") || given(key + ".max"))
      fail(key, "a polygon takes 'points'; 'min' and 'max' belong to shape = \"box\"");
    if (s.points.size() < 3)
      fail(key + ".points", fmt::format("expected 3 corners or more, found {}", s.points.size()));
    no_crossing(s.points, true, key + ".points");
    extent(s, "polygon", key, spacing);
    if (fill<2>(s, spacing_to_look_at(s, spacing, 2), {0.5, 0.5, 0.5}, 0.0, 1).position.empty())
      fail(key, fmt::format("no particle fits into the polygon at a particle spacing of {} m", spacing));
  }

  /// Refuses a polygon or wall line that crosses itself: two of its points are in the wrong order.
  void no_crossing(const std::vector<Point3>& points, bool closed, const std::string& key) const {
    const auto found = self_crossing(points, closed);
    if (!found) return;
    const auto piece = [&](std::size_t i) { return fmt::format("{}-{}", i + 1, (i + 1) % points.size() + 1); };
    fail(key,
         fmt::format("edges {} and {} cross at {} m; expected a line that does not cross itself: put its points in "
                     "the order in which one walks along it",
                     piece(found->first), piece(found->second), shown(found->at)));
  }

  /// A point inside both shapes, away from their edges; empty where they only touch.
  [[nodiscard]] std::optional<Point3> common_point(const Shape& a, const Shape& b, double spacing) const {
    const int dimension = scene_.general.dimension;
    if (a.kind == Shape::Kind::box && b.kind == Shape::Kind::box) {
      const Point3 lower = a.min.cwiseMax(b.min), upper = a.max.cwiseMin(b.max);
      for (int d = 0; d < dimension; ++d)
        if (upper[d] - lower[d] <= 1e-6 * spacing) return std::nullopt;
      return Point3(0.5 * (lower + upper));
    }
    for (const auto* s : {&a, &b})
      for (const auto& point : lattice(*s, spacing, {0.5, 0.5, 0.5})) {
        if (contains(a, point, dimension) && contains(b, point, dimension)) return point;
      }
    return std::nullopt;
  }

  /// Positions of the particles in a shape; on a coarser lattice where there would be too many.
  [[nodiscard]] std::vector<Point3> lattice(const Shape& s, double spacing, const Point3& offset) const {
    std::vector<Point3> points;
    const auto take = [&](const auto& filled) {
      for (const auto& x : filled.position) {
        Point3 point = Point3::Zero();
        point.head(x.size()) = x;
        points.push_back(point);
      }
    };
    const int dimension = scene_.general.dimension;
    const double seen = spacing_to_look_at(s, spacing, dimension);
    if (dimension == 3)
      take(fill<3>(s, seen, offset, 0.0, 1));
    else
      take(fill<2>(s, seen, offset, 0.0, 1));
    return points;
  }

  void no_overlap(const std::vector<Shape>& shapes, const std::string& section, double spacing) const {
    for (std::size_t i = 0; i < shapes.size(); ++i)
      for (std::size_t j = i + 1; j < shapes.size(); ++j)
        if (const auto point = common_point(shapes[i], shapes[j], spacing))
          fail(fmt::format("{}[{}]", section, j),
               fmt::format("overlaps {}[{}], for example at {} m; expected regions that only touch", section, i,
                           shown(*point)));
  }

  /// Refuses a strength that is given twice, and a residual strength that exceeds the initial one.
  void strength_of(const Soil& soil, const std::string& key) const {
    for (const char* other : {".cohesion", ".friction_angle", ".dilation_angle", ".saturated_cohesion"})
      if (soil.undrained_strength && given(key + other))
        fail(key + other, "expected none beside undrained_shear_strength, which takes its place");
    const auto falls = [&](const char* name, const std::optional<double>& to, double from, const char* unit) {
      if (!to) return;
      if (scene_.deformable() && scene_.model_of(soil) != MaterialName::mohr_coulomb)
        fail(fmt::format("{}.residual_{}", key, name),
             fmt::format("soil.model = \"{}\" keeps its strength: expected \"mohr_coulomb\"",
                         scene_.model_of(soil).name));
      if (*to > from)
        fail(fmt::format("{}.residual_{}", key, name),
             fmt::format("expected at most {}, {} {}, found {}", name, from, unit, *to));
      if (!soil.softening_slip)
        fail(key + ".softening_slip",
             fmt::format("expected the slip over which residual_{} is reached, found none", name));
    };
    falls("cohesion", soil.residual_cohesion, soil.cohesion, "Pa");
    falls("friction_angle", soil.residual_friction_angle, soil.friction_angle, "degrees");
    falls("dilation_angle", soil.residual_dilation_angle, soil.dilation_angle, "degrees");
    const double left = soil.residual_friction_angle.value_or(soil.friction_angle),
                 spread = soil.residual_dilation_angle.value_or(soil.dilation_angle);
    if (spread > left)
      fail(key + ".residual_friction_angle",
           fmt::format("expected at least the residual dilation angle of {} degrees, found {}", spread, left));
  }

  /// Checks a soil by the rules of its material, and that the case provides what the material needs.
  void material_of(const Soil& soil, const std::string& key) const {
    if (!scene_.deformable()) return;
    const Material kind = material(scene_.model_of(soil));
    if (kind.begins_under_stress && !(soil.earth_pressure_at_rest && scene_.solid.initial_rest))
      fail(key + ".earth_pressure_at_rest",
           fmt::format("soil.model = \"{}\" has no state without stress: expected the ratio of horizontal to vertical "
                       "stress at the start, and solid.initial_rest = true; found {}",
                       kind.name, soil.earth_pressure_at_rest ? "no search for rest" : "none"));
    if (kind.judge)
      kind.judge(soil,
                 [&](std::string_view of, const std::string& what) { fail(fmt::format("{}.{}", key, of), what); });
  }

  void contact_of(const Soil& soil, const std::string& key) const {
    if (!soil.contact_porosity || !scene_.deformable()) return;
    if (!(*soil.contact_porosity < soil.porosity))
      fail(key + ".contact_porosity",
           fmt::format(
               "expected less than the porosity of {} (grains that touch at the start need no contact_porosity), "
               "found {}",
               soil.porosity, *soil.contact_porosity));
    if (scene_.solid.initial_rest)
      fail(key + ".contact_porosity", "grains in suspension are not at rest; expected solid.initial_rest = false");
    if (scene_.is_field())
      fail(key + ".contact_porosity",
           "water as a field needs soil that can stand at rest; expected fluid.representation = \"particles\"");
  }

  void soils() const {
    const double spacing = scene_.deformable() ? scene_.solid.particle_spacing : scene_.fluid.particle_spacing;
    std::vector<Shape> shapes;
    for (std::size_t i = 0; i < scene_.soils.size(); ++i) {
      const auto& soil = scene_.soils[i];
      const std::string key = fmt::format("soil[{}]", i);
      shape(soil.shape, key, spacing);
      if (soil.dilation_angle > soil.friction_angle)
        fail(key + ".dilation_angle", fmt::format("expected at most the friction angle of {} degrees, found {}",
                                                  soil.friction_angle, soil.dilation_angle));
      strength_of(soil, key);
      material_of(soil, key);
      if (soil.saturated_cohesion && *soil.saturated_cohesion > soil.cohesion)
        fail(key + ".saturated_cohesion",
             fmt::format("expected at most the cohesion at the initial saturation, {} Pa, found {} Pa", soil.cohesion,
                         *soil.saturated_cohesion));
      if (const double e = soil.porosity / (1.0 - soil.porosity);
          soil.maximum_void_ratio && *soil.maximum_void_ratio < e)
        fail(key + ".maximum_void_ratio",
             fmt::format("expected at least the initial void ratio, {:.4g} for a porosity of {}, found {}", e,
                         soil.porosity, *soil.maximum_void_ratio));
      contact_of(soil, key);
      seepage(soil, key);
      erosion(soil, key);
      shapes.push_back(soil.shape);
    }
    no_overlap(shapes, "soil", spacing);
  }

  void seepage(const Soil& soil, const std::string& key) const {
    for (const auto& law : porous::seepage_laws()) {
      const bool chosen = soil.seepage_law == &law;
      for (const auto& p : law.parameters) {
        if (chosen && p.needed && !(porous::parameter(soil, p) > 0.0))
          fail(key + "." + p.key, fmt::format("the law \"{}\" needs it, a positive number{}, found none", law.name,
                                              p.unit.empty() ? "" : " of " + p.unit));
        const bool of_material = scene_.deformable() && material(scene_.model_of(soil)).has_key(p.key);
        if (!chosen && !of_material && given(key + "." + p.key))
          fail(key + "." + p.key, fmt::format("belongs to seepage_law = \"{}\"", law.name));
      }
      if (chosen && !law.takes_conductivity && given(key + ".hydraulic_conductivity"))
        fail(key + ".hydraulic_conductivity",
             fmt::format("the law \"{}\" finds the conductivity itself; another law takes it as given", law.name));
    }
  }

  /// Checks that free water which can erode a soil is computed beside it, and the parameters of its law.
  void erosion(const Soil& soil, const std::string& key) const {
    if (!soil.erosion) return;
    const std::string here = key + ".erosion";
    if (scene_.general.dimension == 3) fail(here, "erosion is computed in 2D only: expected none in 3D");
    if (!scene_.deformable())
      fail(here, fmt::format("soil that loses its surface must be computed: expected solid.model = \"elastic\" or a "
                             "material that can yield, found \"{}\"",
                             scene_.solid.model.name));
    if (!scene_.has_water() || scene_.is_field())
      fail(here, fmt::format("only free water erodes: expected [[fluid.region]] and fluid.representation = "
                             "\"particles\", found {}",
                             scene_.is_field() ? "water as a field" : "no water"));
    if (scene_.coupling.scheme == CouplingCase::Scheme::parallel || !scene_.predicts())
      fail(scene_.predicts() ? "coupling.scheme" : "fluid.skeleton_response",
           fmt::format("soil from which particles leave has other points at a window's end than at its start: expected "
                       "{}",
                       scene_.predicts() ? "\"iterated\" or \"serial\"" : "true"));
    if (!scene_.loads.empty())
      fail("load[0]",
           "loads act on particles of the soil's surface, which erosion carries off: expected none beside "
           "[soil.erosion]");
    for (const auto& law : porous::erosion_laws())
      for (const auto& p : law.parameters) {
        const bool mine = &law == soil.erosion->law;
        if (mine && p.needed && !(soil.erosion->numbers.at(p.key) > 0.0))
          fail(here + "." + p.key,
               fmt::format("the law \"{}\" needs it, a positive number of {}, found none", law.name, p.unit));
        if (!mine && given(here + "." + p.key) &&
            std::ranges::none_of(soil.erosion->law->parameters, [&](const auto& own) { return own.key == p.key; }))
          fail(here + "." + p.key, fmt::format("belongs to erosion.model = \"{}\"", law.name));
      }
  }

  /// Whether a wall within one spacing of the particles supports their soil: one that faces upwards, or a vertical one
  /// to which the soil is fixed.
  [[nodiscard]] bool holds(const Wall& wall, const std::vector<Point3>& points, double spacing) const {
    const Point3 down = scene_.general.gravity.normalized();
    auto near = [&](const Point3& point, const Point3& normal, const Point3& tangent, double length) {
      const double facing = normal.dot(down);
      if (wall.soil == Wall::ForSoil::fixed ? facing > 1e-6 : facing > -1e-6) return false;
      return std::any_of(points.begin(), points.end(), [&](const Point3& x) {
        const double away = normal.dot(x - point), along = tangent.dot(x - point);
        return away > -0.5 * spacing && away < spacing && along > -spacing && along < length + spacing;
      });
    };
    if (wall.shape) {
      Surfaces surfaces;
      surfaces.add(wall, 0);
      return std::ranges::any_of(points, [&](const Point3& x) {
        const auto around = surfaces.walls_near(x, spacing);
        return std::ranges::any_of(around.all(), [&](const Surfaces::WallPoint& point) {
          const double facing = point.normal.dot(down);
          return wall.soil == Wall::ForSoil::fixed ? facing <= 1e-6 : facing <= -1e-6;
        });
      });
    }
    const Face& f = wall.face;
    if (f.points.empty()) return near(f.point, f.normal.normalized(), Point3::Zero(), 1.0);
    for (std::size_t i = 0; i + 1 < f.points.size(); ++i) {
      const Point3 way = f.points[i + 1] - f.points[i];
      const Point3 tangent = way.normalized();
      if (near(f.points[i], Point3(-tangent.y(), tangent.x(), 0.0), tangent, way.norm())) return true;
    }
    return false;
  }

  /// Refuses soil that neither rests on a wall or on supported soil nor starts in motion. Refuses soil that falls into
  /// water and conducts too little for a stable exchange with it (docs/stability.md).
  void soils_are_supported() const {
    const Point3& gravity = scene_.general.gravity;
    if (!scene_.deformable() || !(gravity.norm() > 0.0)) return;
    for (const int axis : scene_.general.periodic)
      if (gravity[axis] != 0.0) return;
    const double spacing = scene_.solid.particle_spacing;
    const std::size_t n = scene_.soils.size();
    std::vector<std::vector<Point3>> points(n);
    std::vector<char> supported(n, 0);
    for (std::size_t i = 0; i < n; ++i) {
      const Shape& shape = scene_.soils[i].shape;
      points[i] = lattice(shape, spacing, scene_.solid.offset);
      const double seen = spacing_to_look_at(shape, spacing, scene_.general.dimension);
      for (const auto& wall : scene_.walls)
        if (wall.soil != Wall::ForSoil::none && holds(wall, points[i], seen)) supported[i] = 1;
    }
    const Point3 down = 1.001 * gravity.normalized();
    for (bool more = true; more;) {
      more = false;
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n && !supported[i]; ++j) {
          if (!supported[j]) continue;
          const auto& below = scene_.soils[j].shape;
          const Point3 step = spacing_to_look_at(scene_.soils[i].shape, spacing, scene_.general.dimension) * down;
          supported[i] = std::any_of(points[i].begin(), points[i].end(), [&](const Point3& x) {
            return contains(below, Point3(x + step), scene_.general.dimension);
          });
          more = more || supported[i];
        }
    }
    // m/s; in measurements the exchange was stable above these conductivities
    constexpr double least_beside_water = 1e-3, least_under_water = 1e-5;
    for (std::size_t i = 0; i < n; ++i) {
      if (supported[i]) continue;
      const std::string key = fmt::format("soil[{}]", i);
      const Soil& soil = scene_.soils[i];
      if (scene_.solid.initial_rest)
        fail(key,
             "nothing holds the soil up: expected a [[wall]] for soil under it, a soil that rests on one, or "
             "solid.initial_rest = false for soil that falls");
      if (!scene_.coupled() || !soil.seepage_law->takes_conductivity) continue;
      const bool under_water = std::all_of(points[i].begin(), points[i].end(), [&](const Point3& x) {
        return std::any_of(scene_.fluid.regions.begin(), scene_.fluid.regions.end(),
                           [&](const Shape& region) { return contains(region, x, scene_.general.dimension); });
      });
      const double least = under_water ? least_under_water : least_beside_water;
      if (soil.hydraulic_conductivity < least)
        fail(key + ".hydraulic_conductivity",
             fmt::format("soil that falls, {} water, has no stable exchange with it below {:g} m/s: expected at least "
                         "that, or a [[wall]] that holds it up, found {:g}",
                         under_water ? "under" : "beside", least, soil.hydraulic_conductivity));
    }
  }

  void fluid_regions() const {
    if (scene_.coupled() && scene_.fluid.drag_form != FluidCase::DragForm::pointwise)
      fail(
          "fluid.drag_form",
          "the sum over pairs needs the soil's particles, which a moving soil keeps to itself; expected \"pointwise\", "
          "or solid.model = \"rigid\"");
    for (std::size_t i = 0; i < scene_.fluid.regions.size(); ++i)
      shape(scene_.fluid.regions[i], fmt::format("fluid.region[{}]", i), scene_.fluid.particle_spacing);
    no_overlap(scene_.fluid.regions, "fluid.region", scene_.fluid.particle_spacing);
  }

  void face(const Face& f, const std::string& key) const {
    const bool plane = given(key + ".point") || given(key + ".normal");
    if (f.within && !plane && f.points.empty()) return;
    const bool line = given(key + ".points") || !f.points.empty();  // lines that parts() adds stand in no file
    if (line == plane)
      fail(key,
           "expected either 'points' (2D, walked with the domain on the left) or 'point' and 'normal' (into the "
           "domain)");
    if (plane) {
      if (!given(key + ".point") || !given(key + ".normal")) fail(key, "expected 'point' and 'normal' together");
      if (!(f.normal.norm() > 0.0)) fail(key + ".normal", "expected a direction, found a vector of length zero");
      return;
    }
    if (scene_.general.dimension != 2)
      fail(key + ".points", "faces by 'points' are for dimension = 2; use 'point' and 'normal'");
    if (f.points.size() < 2) fail(key + ".points", fmt::format("expected 2 points or more, found {}", f.points.size()));
    for (std::size_t i = 0; i + 1 < f.points.size(); ++i)
      if (!((f.points[i + 1] - f.points[i]).norm() > 0.0))
        fail(key + ".points", fmt::format("expected different points in a row, found {} twice", shown(f.points[i])));
    const bool closed = f.points.front() == f.points.back();
    no_crossing(closed ? std::vector<Point3>(f.points.begin(), f.points.end() - 1) : f.points, closed, key + ".points");
  }

  void faces() const {
    for (std::size_t i = 0; i < scene_.walls.size(); ++i)
      if (!scene_.walls[i].shape) face(scene_.walls[i].face, fmt::format("wall[{}]", i));
    for (std::size_t i = 0; i < scene_.water_faces.size(); ++i) {
      const std::string key = fmt::format("water_face[{}]", i);
      const auto& f = scene_.water_faces[i];
      face(f.face, key);
      const int kinds =
          (f.head && !f.discharge) + f.pressure.has_value() + f.discharge.has_value() + f.outlet + f.free_water;
      if (kinds != 1)
        fail(key, fmt::format("expected one of 'head', 'pressure', 'discharge' and 'outlet', found {}",
                              kinds == 0 ? "none" : "more"));
      if (f.wave_amplitude && !f.pressure)
        fail(key + ".wave_amplitude", "is added to the pressure of the face: expected 'pressure' beside it");
      if (f.basin_area && !f.discharge)
        fail(key,
             "'basin_area' belongs to a 'discharge': expected what is poured into the basin, 0 if nothing is, found "
             "none");
      for (const char* other : {"basin_rain", "spill_level"})
        if (given(key + "." + other) && !f.basin_area)
          fail(key + "." + other, "belongs to a basin: expected 'basin_area' and 'discharge' with it, found neither");
      inlet(f, key);
      if (f.basin_area)
        for (std::size_t j = 0; j < f.basin_area->knots.size(); ++j) {
          const auto [z, area] = f.basin_area->knots[j];
          if (!(area > 0.0))
            fail(key + ".basin_area", fmt::format("expected positive areas, found {} at elevation {} m", area, z));
        }
      if (f.basin_area && f.spill_level) {
        const double bottom = f.basin_area->knots.front().first, first = basin_first_level(f);
        if (!(*f.spill_level > bottom) || *f.spill_level < first)
          fail(key + ".spill_level",
               fmt::format("expected a level above the basin's bottom at {} m and not below the level at time zero, {} "
                           "m, found {} m",
                           bottom, first, *f.spill_level));
      }
      if (!f.free_water) own_name(scene_.water_faces, i, "water_face");
      for (std::size_t j = 0; j < i; ++j)
        if (const auto place = shared_place(f.face, scene_.water_faces[j].face, scene_.fluid.particle_spacing))
          fail(key, fmt::format("lies on {} at {} m: expected one water face at each place",
                                named("water_face", j, scene_.water_faces[j].name), shown(*place)));
    }
    for (std::size_t i = 0; i < scene_.rains.size(); ++i) {
      face(scene_.rains[i].face, fmt::format("rain[{}]", i));
      own_name(scene_.rains, i, "rain");
    }
    for (std::size_t i = 0; i < scene_.loads.size(); ++i) {
      const std::string key = fmt::format("load[{}]", i);
      face(scene_.loads[i].face, key);
      if (scene_.loads[i].pressure && given(key + ".traction"))
        fail(key, "expected either 'traction' or 'pressure', found both");
      if (const auto& start = scene_.loads[i].start; start && *start < 0.0)
        fail(key + ".start", fmt::format("time begins at 0 s, found {} s: expected none for a load that always acts, "
                                         "under which the soil comes to rest before time zero",
                                         *start));
      if (scene_.loads[i].factor && scene_.solid.quiet)
        fail(key + ".factor", "soil that sleeps does not see a load that changes: expected no [solid.quiet] beside it");
    }
  }

  /// Refuses an inlet that is no gap in a wall: none of its ends meets a wall, or water lies behind the inlet.
  void is_an_opening(const WaterFace& f, const std::string& key) const {
    const auto &a = f.face.points.front(), &b = f.face.points.back();
    const double slack = 1e-6 * (b - a).norm();
    const auto meets = [&](const Point3& end, const Face& wall) {
      if (wall.points.empty()) return std::abs(wall.normal.normalized().dot(end - wall.point)) <= slack;
      for (const auto& piece : pieces(wall)) {
        const Point3 s = piece.b - piece.a;
        const double along = std::clamp(s.dot(end - piece.a) / s.squaredNorm(), 0.0, 1.0);
        if ((piece.a + along * s - end).norm() <= slack) return true;
      }
      return false;
    };
    const bool met = std::any_of(scene_.walls.begin(), scene_.walls.end(), [&](const Wall& wall) {
      return wall.water != Wall::ForWater::none && (meets(a, wall.face) || meets(b, wall.face));
    });
    if (!met)
      fail(
          key + ".points",
          fmt::format("an inlet is an opening in a wall, but neither of its ends, {} and {} m, meets one: it is inside "
                      "a wall, off the domain or in the middle of the water; expected a gap between walls",
                      shown(a), shown(b)));
    for (const auto& piece : pieces(f.face))
      for (const auto& place : places_on(piece))
        if (in_fluid_region(scene_, place.right))
          fail(key + ".points", fmt::format("a [[fluid.region]] lies behind the inlet, for example at {} m; expected "
                                            "water on its left side only",
                                            shown(place.at)));
  }

  /// Checks the kind of a face: either a reservoir of still water, which needs no particles, stands behind it, or it is
  /// an inlet through which water particles enter.
  void inlet(const WaterFace& f, const std::string& key) const {
    const bool real = is_inlet(scene_, f);
    if (f.discharge && !f.basin_area && !real)
      fail(key + ".discharge",
           scene_.general.dimension == 2
               ? "soil touches the face; expected 'basin_area' with it (a basin behind soil), or an inlet before which "
                 "no soil lies"
               : "inlets of water particles are for dimension = 2; expected 'basin_area' with it");
    if (real && f.face.points.size() != 2)
      fail(key + ".points",
           fmt::format("an inlet is one straight opening; expected 2 points, found {}", f.face.points.size()));
    if (real) is_an_opening(f, key);
    if (real || !f.head || f.face.points.empty()) return;
    const auto crest = crest_of(scene_, f);
    double highest = -HUGE_VAL;
    for (const auto& [time, value] : f.head->knots) highest = std::max(highest, value);
    if (!crest || highest <= crest->elevation + 1e-9) return;
    if (const std::string why = no_way_over(scene_, *crest); !why.empty())
      fail(key + ".head",
           fmt::format("the water behind the face rises to {} m, above the face's upper end at {} m, where no wall "
                       "touches it, and cannot run over there: {}; expected a lower head, a face or wall up to it, or "
                       "a reservoir of water particles (an inlet away from the soil)",
                       highest, crest->elevation, why));
  }

  struct Piece {
    Point3 a, b;
  };
  static std::vector<Piece> pieces(const Face& f) {
    std::vector<Piece> result;
    for (std::size_t i = 0; i + 1 < f.points.size(); ++i) result.push_back({f.points[i], f.points[i + 1]});
    return result;
  }
  static double cross(const Point3& a, const Point3& b) { return a.x() * b.y() - a.y() * b.x(); }

  /// Why two straight pieces cannot both be walls; empty where they can: they are apart, or touch at an end.
  [[nodiscard]] std::string conflict(const Piece& p, const Piece& q) const {
    const Point3 r = p.b - p.a, s = q.b - q.a, d = q.a - p.a;
    const double tolerance = 1e-9 * std::max(r.norm(), s.norm());
    if (std::abs(cross(r, s)) <= 1e-9 * r.norm() * s.norm()) {
      if (std::abs(cross(r, d)) > tolerance * r.norm()) return {};
      const double at_a = d.dot(r) / r.norm(), at_b = (q.b - p.a).dot(r) / r.norm();
      const double from = std::max(0.0, std::min(at_a, at_b)), to = std::min(r.norm(), std::max(at_a, at_b));
      if (to - from <= tolerance) return {};
      const Point3 direction = r.normalized();
      return fmt::format("lies on {{}} from {} to {} m", shown(p.a + from * direction), shown(p.a + to * direction));
    }
    const double t = cross(d, s) / cross(r, s), u = cross(d, r) / cross(r, s);
    constexpr double end = 1e-6;
    if (t <= end || t >= 1.0 - end || u <= end || u >= 1.0 - end) return {};
    return fmt::format("crosses {{}} at {} m, away from the ends", shown(p.a + t * r));
  }

  /// Whether two faces are the same plane.
  static bool same_plane(const Face& f, const Face& g) {
    if (!f.points.empty() || !g.points.empty() || f.within || g.within) return false;
    const Point3 n = f.normal.normalized(), m = g.normal.normalized();
    return n.cross(m).norm() < 1e-9 && std::abs(n.dot(g.point - f.point)) < 1e-9 * (1.0 + g.point.norm());
  }

  [[nodiscard]] std::string conflict(const Face& f, const Face& g) const {
    if (same_plane(f, g)) return "lies on {}";
    for (const auto& p : pieces(f))
      for (const auto& q : pieces(g))
        if (auto reason = conflict(p, q); !reason.empty()) return reason;
    return {};
  }

  void walls() const {
    const auto& walls = scene_.walls;
    const auto named = [&](std::size_t i) { return Complaints::named("wall", i, walls[i].name); };
    const auto& g = scene_.general;
    for (std::size_t i = 0; i < walls.size(); ++i) {
      if (walls[i].soil == Wall::ForSoil::rough && g.dimension == 3 &&
          !((g.domain_max - g.domain_min).minCoeff() > 0.0))
        fail(fmt::format("wall[{}].soil", i),
             fmt::format(
                 "\"rough\" holds soil still behind the wall, in 3D within a box; expected case.domain_min below "
                 "case.domain_max along every axis, found {} and {}; give the box that the soil may reach",
                 shown(g.domain_min), shown(g.domain_max)));
      if (walls[i].soil != Wall::ForSoil::frictional && walls[i].friction_angle > 0.0)
        fail(fmt::format("wall[{}].friction_angle", i), "belongs to soil = \"frictional\"");
      for (std::size_t j = i + 1; j < walls.size(); ++j) {
        const bool both_water = walls[i].water != Wall::ForWater::none && walls[j].water != Wall::ForWater::none;
        const bool both_soil = walls[i].soil != Wall::ForSoil::none && walls[j].soil != Wall::ForSoil::none;
        if ((!both_water && !both_soil) || walls[i].shape || walls[j].shape) continue;
        if (const auto reason = conflict(walls[i].face, walls[j].face); !reason.empty())
          fail(fmt::format("wall[{}]", j), fmt::format("{} {}; expected walls that meet at their ends only", named(j),
                                                       fmt::format(fmt::runtime(reason), named(i))));
      }
      for (std::size_t j = 0; j < scene_.water_faces.size(); ++j) {
        if (walls[i].water == Wall::ForWater::none || walls[i].shape) continue;
        const auto reason = conflict(walls[i].face, scene_.water_faces[j].face);
        if (!reason.empty())
          fail(fmt::format("water_face[{}]", j),
               fmt::format("{}, which lets no water through; set water = \"none\" there or move one of them",
                           fmt::format(fmt::runtime(reason), named(i))));
      }
    }
  }

  /// Refuses walls on the border at which the case repeats itself: what lies there continues on the other side.
  void nothing_on_periodic_sides() const {
    const auto& g = scene_.general;
    for (const int axis : g.periodic)
      for (std::size_t w = 0; w < scene_.walls.size(); ++w) {
        const Wall& wall = scene_.walls[w];
        const bool counts = (wall.water != Wall::ForWater::none && scene_.has_water()) ||
                            (wall.soil != Wall::ForSoil::none && scene_.deformable());
        if (!counts || wall.shape) continue;
        const double slack = 1e-6 * (g.domain_max[axis] - g.domain_min[axis]);
        const auto on_a_side = [&](const Point3& a, const Point3& b) {
          return std::ranges::any_of(std::array{g.domain_min[axis], g.domain_max[axis]}, [&](double side) {
            return std::abs(a[axis] - side) < slack && std::abs(b[axis] - side) < slack;
          });
        };
        const bool plane_there = wall.face.points.empty() && on_a_side(wall.face.point, wall.face.point) &&
                                 std::abs(wall.face.normal.normalized()[axis]) > 1.0 - 1e-9;
        if (plane_there ||
            std::ranges::any_of(pieces(wall.face), [&](const Piece& piece) { return on_a_side(piece.a, piece.b); }))
          fail(fmt::format("wall[{}]", w),
               fmt::format("lies on a side at which the case repeats itself along {} (case.periodic): expected no "
                           "wall there, or a case that is not periodic",
                           "xyz"[axis]));
      }
  }

  void pore_pressures() const {
    for (std::size_t i = 0; i < scene_.pore_pressures.size(); ++i) {
      const auto& p = scene_.pore_pressures[i];
      const std::string key = fmt::format("pore_pressure[{}]", i);
      if (scene_.has_water())
        fail(key, "the case has water of its own, whose pressure the fluid computes; expected one or the other");
      if (!scene_.deformable()) fail(key, "with solid.model = \"rigid\" there is no skeleton for it to act on");
      if (p.region) shape(*p.region, key + ".region", 0.0);
      if (p.head.has_value() == p.pressure.has_value())
        fail(key, fmt::format("expected either 'head' or 'pressure', found {}", p.head ? "both" : "neither"));
      if (p.head && !(scene_.general.gravity.norm() > 0.0))
        fail(key + ".head", "a head needs gravity, found case.gravity of length zero; use 'pressure'");
      if (p.to_head && !p.head) fail(key + ".to_head", "expected 'head' at 'from' with it");
      if (p.to_head && !((p.to - p.from).norm() > 0.0))
        fail(key + ".to", fmt::format("expected a point other than 'from', found {} twice", shown(p.to)));
    }
  }

  [[nodiscard]] bool ground(const Point3& x) const { return in_fluid_region(scene_, x) || soil_at(scene_, x); }

  /// A position on a straight piece, and the points a quarter spacing to its left and right.
  struct Place {
    Point3 at, left, right;
  };
  [[nodiscard]] std::vector<Place> places_on(const Piece& piece) const {
    std::vector<Place> result;
    const Point3 along = piece.b - piece.a;
    const Point3 aside = 0.25 * scene_.fluid.particle_spacing * Point3(-along.y(), along.x(), 0.0).normalized();
    const int parts = std::clamp(static_cast<int>(along.norm() / scene_.fluid.particle_spacing), 1, 10000);
    for (int k = 0; k < parts; ++k) {
      const Point3 x = piece.a + (k + 0.5) / parts * along;
      result.push_back({x, x + aside, x - aside});
    }
    return result;
  }

  /// Refuses water or soil drawn behind a wall by point and normal: such a plane has no ends.
  void nothing_behind_planes() const {
    for (std::size_t i = 0; i < scene_.walls.size(); ++i) {
      const Wall& wall = scene_.walls[i];
      if (!wall.face.points.empty() || wall.shape) continue;
      const Point3 normal = wall.face.normal.normalized();
      const auto look = [&](const Shape& s, double spacing, const std::string& key, const char* what) {
        // Packing moves particles by up to a spacing before a run begins.
        const double allowed = scene_.general.dimension == 3 && is_packed(s) ? spacing : 1e-6 * spacing;
        for (const auto& x : lattice(s, spacing, {0.5, 0.5, 0.5}))
          if (normal.dot(x - wall.face.point) < -allowed)
            fail(key, fmt::format("{} lies behind {}, for example at {} m: a wall by 'point' and 'normal' is a plane "
                                  "without end; expected all of it on the side to which the normal points",
                                  what, named("wall", i, wall.name), shown(x)));
      };
      if (wall.water != Wall::ForWater::none)
        for (std::size_t r = 0; r < scene_.fluid.regions.size(); ++r)
          look(scene_.fluid.regions[r], scene_.fluid.particle_spacing, fmt::format("fluid.region[{}]", r), "water");
      if (wall.soil != Wall::ForSoil::none && scene_.deformable())
        for (std::size_t s = 0; s < scene_.soils.size(); ++s)
          look(scene_.soils[s].shape, scene_.solid.particle_spacing, fmt::format("soil[{}]", s), "soil");
    }
  }

  /// Checks of walls with a shape: what is beside them, and that all water begins on the side of the domain.
  void shaped_walls() const {
    for (std::size_t i = 0; i < scene_.walls.size(); ++i) {
      const Wall& wall = scene_.walls[i];
      if (!wall.shape) continue;
      const std::string key = fmt::format("wall[{}]", i);
      const auto no = [&](bool there, const std::string& what) {
        if (there)
          fail(key + ".shape",
               "a wall with a shape needs 3D, and neither periodic sides nor a [[water_face]]; found " + what);
      };
      no(scene_.general.dimension != 3, "dimension = 2; expected a wall by 'points'");
      no(!scene_.general.periodic.empty(), "periodic sides; expected none");
      no(!scene_.water_faces.empty(), "a [[water_face]]; expected none, or walls by 'point' and 'normal'");
      if (scene_.deformable() && wall.soil != Wall::ForSoil::none) beside_soil(wall, key);
      if (wall.water == Wall::ForWater::none) continue;
      if (const auto thin = thin_place(*wall.shape, wall.domain, scene_.fluid.particle_spacing))
        fail(key + ".shape",
             fmt::format(
                 "is {:.4g} m thick at {} m: water on its two sides would interact through it; expected {:.3g} m or "
                 "more, {:g} particle spacings",
                 thin->thickness, shown(thin->at), least_thickness * scene_.fluid.particle_spacing, least_thickness));
      for (std::size_t r = 0; r < scene_.fluid.regions.size(); ++r)
        nothing_in(wall, i, scene_.fluid.regions[r], scene_.fluid.particle_spacing, scene_.fluid.offset,
                   fmt::format("fluid.region[{}]", r), "water");
    }
  }

  /// Refuses a wall with a shape that makes wrong images of moving soil.
  void beside_soil(const Wall& wall, const std::string& key) const {
    const double dx = scene_.solid.particle_spacing;
    if (wall.soil == Wall::ForSoil::rough)
      fail(key + ".soil", "\"rough\" is for planes; expected \"roller\", \"fixed\" or \"frictional\" beside a shape");
    if (wall.domain == Wall::Domain::outside && wall.shape->solid->parts().size() > 1)
      fail(key + ".shape",
           "an obstacle in moving soil may not be cut by others, since its edges turn away from the soil");
    if (const auto thin = thin_place(*wall.shape, wall.domain, dx))
      fail(key + ".shape", fmt::format("is {:.4g} m thick at {} m: soil on its two sides would interact through it; "
                                       "expected {:.3g} m or more, {:g} particle spacings",
                                       thin->thickness, shown(thin->at), least_thickness * dx, least_thickness));
    // Only places that soil can reach count: not those behind other walls or above the highest soil.
    const Point3 up = -scene_.general.gravity.normalized();
    double top = -HUGE_VAL;
    for (const Soil& soil : scene_.soils)
      for (const auto& x : lattice(soil.shape, dx, scene_.solid.offset)) top = std::max(top, up.dot(x) + dx);
    Surfaces others;
    for (const Wall& other : scene_.walls) {
      if (&other == &wall || other.soil == Wall::ForSoil::none) continue;
      others.add(other, 0);
    }
    const auto in_reach = [&](const Point3& x) {
      return (up.isZero() || up.dot(x) < top + least_thickness * dx) && others.holds(x);
    };
    if (const auto bent = bent_place(*wall.shape, wall.domain, dx, in_reach)) {
      if (bent->turn > 0.0)
        fail(key + ".shape",
             fmt::format("has an edge at {} m that turns away from the soil by {:.3g} degrees, behind which "
                         "moving soil has no images; expected {:g} degrees at most, or soil = \"none\" "
                         "for a wall that no soil reaches",
                         shown(bent->at), bent->turn, most_turned_away));
      fail(key + ".shape",
           fmt::format(
               "has a radius of curvature of {:.3g} m at {} m; expected {:.3g} m or more beside moving soil, {:g} "
               "particle spacings",
               bent->radius, shown(bent->at), least_radius * dx, least_radius));
    }
  }

  /// Refuses moving soil that is drawn behind walls with a shape, or so that the images behind these would be wrong.
  void soil_beside_shapes() const {
    if (!scene_.deformable() || scene_.general.dimension != 3) return;
    Surfaces walls;
    bool any = false;
    for (std::size_t i = 0; i < scene_.walls.size(); ++i) {
      const Wall& wall = scene_.walls[i];
      if (wall.soil == Wall::ForSoil::none) continue;
      any = any || wall.shape;
      walls.add(wall, static_cast<int>(i));
    }
    if (!any) return;
    const double dx = scene_.solid.particle_spacing;
    constexpr double sharp = -0.51;   // cosine between the normals of walls that meet at 60 degrees, less rounding
    constexpr double unpacked = 0.3;  // spacings; rows along a wall and packed particles lie half a spacing from it
    constexpr double near = 1.5;      // spacings; walls that are both within this distance leave no room for two rows
    for (std::size_t s = 0; s < scene_.soils.size(); ++s) {
      const Shape& shape = scene_.soils[s].shape;
      const std::string key = fmt::format("soil[{}]", s);
      for (std::size_t i = 0; i < scene_.walls.size(); ++i)
        if (scene_.walls[i].shape && scene_.walls[i].soil != Wall::ForSoil::none)
          nothing_in(scene_.walls[i], i, shape, dx, scene_.solid.offset, key, "soil");
      const bool packed = is_packed(shape);
      for (const auto& x : lattice(shape, dx, scene_.solid.offset)) {
        const auto around = walls.walls_near(x, near * dx);
        if (!packed && around.size > 0 && around.point[0].distance < unpacked * dx)
          fail(key,
               fmt::format("the rows of its particles meet {} at an angle, at {} m: stresses there would be wrong; "
                           "expected a soil with the wall's shape, or cut by it ('within', 'without')",
                           named("wall", static_cast<std::size_t>(around.point[0].boundary),
                                 scene_.walls[static_cast<std::size_t>(around.point[0].boundary)].name),
                           shown(x)));
        for (std::size_t a = 0; a < around.size; ++a)
          for (std::size_t b = 0; b < a; ++b)
            if (around.point[a].normal.dot(around.point[b].normal) < sharp)
              fail(key,
                   fmt::format("lies at {} m between walls that meet at less than 60 degrees or are less than three "
                               "particle spacings apart: images beside walls with a shape would be wrong there",
                               shown(x)));
      }
    }
  }

  void nothing_in(const Wall& wall, std::size_t i, const Shape& region, double dx, const Point3& offset,
                  const std::string& key, const char* what) const {
    // In shapes with slanted or curved faces, packing moves particles by up to a spacing before a run begins.
    const double allowed = region.solid ? dx : 1e-6 * dx;
    const bool inside = wall.domain == Wall::Domain::inside;
    for (const auto& x : lattice(region, dx, offset)) {
      const double depth = wall.shape->solid->depth(x, 2.0 * dx);
      if ((inside ? -depth : depth) > allowed)
        fail(key,
             fmt::format(
                 "{} lies {} {}, for example at {} m; expected none there: cut the region by 'within' or 'without'",
                 what, inside ? "outside of" : "in", named("wall", i, wall.name), shown(x)));
    }
  }

  /// Refuses walls and faces with water or soil on their right only; the domain must be on their left.
  void sides() const {
    for (std::size_t i = 0; i < scene_.walls.size(); ++i) {
      const auto& wall = scene_.walls[i];
      if (wall.water == Wall::ForWater::none) continue;
      const std::string key = fmt::format("wall[{}]", i);
      for (const auto& piece : pieces(wall.face)) {
        std::size_t left = 0;
        std::optional<Point3> right;
        for (const auto& place : places_on(piece)) {
          left += ground(place.left);
          if (ground(place.right)) right = place.at;
        }
        if (left == 0 && right)
          fail(key + ".points",
               fmt::format(
                   "water or soil lies to the right of the walk from {} to {}, for example at {} m; expected the "
                   "domain on the left: turn the order of the points round",
                   shown(piece.a), shown(piece.b), shown(*right)));
      }
    }
    for (std::size_t i = 0; i < scene_.water_faces.size(); ++i) {
      const Face& face = scene_.water_faces[i].face;
      const std::string key = fmt::format("water_face[{}].points", i);
      std::size_t left = 0, right = 0;
      for (const auto& piece : pieces(face))
        for (const auto& place : places_on(piece)) {
          left += ground(place.left);
          right += ground(place.right);
        }
      if (face.points.empty() || left > 0 || scene_.water_faces[i].outlet) {
        nothing_behind(i);
        continue;
      }
      if (right == 0 && is_inlet(scene_, scene_.water_faces[i])) continue;
      if (right > 0)
        fail(key,
             "soil and water lie to the right of the walk; expected the domain on the left: turn the order of the "
             "points round");
      fail(key, fmt::format("no [[soil]] and no [[fluid.region]] touches the face from {} to {} m: it is inside a wall "
                            "or off the domain; expected a side of one of them",
                            shown(face.points.front()), shown(face.points.back())));
    }
  }

  /// Refuses water drawn behind a face, which stands for all water there: that water would be deleted immediately.
  void nothing_behind(std::size_t i) const {
    const WaterFace& face = scene_.water_faces[i];
    if (is_inlet(scene_, face)) return;  // is_an_opening() checks it
    const auto complain = [&](std::size_t region, const Point3& x) {
      fail(
          fmt::format("fluid.region[{}]", region),
          fmt::format("water lies behind {}, for example at {} m, where the face takes it away at once; expected water "
                      "before the face only: {}, or draw walls around it instead of the face",
                      named("water_face", i, face.name), shown(x),
                      face.outlet ? "leave it out" : "give its level by the face's 'head'"));
    };
    for (std::size_t r = 0; r < scene_.fluid.regions.size(); ++r) {
      const Shape& region = scene_.fluid.regions[r];
      for (const auto& piece : pieces(face.face))
        for (const auto& place : places_on(piece))
          if (contains(region, place.right, scene_.general.dimension)) complain(r, place.right);
      if (!is_reservoir(scene_, face) || !face.head) continue;
      const Point3 up = -scene_.general.gravity.normalized();
      for (const auto& x : lattice(region, scene_.fluid.particle_spacing, {0.5, 0.5, 0.5}))
        if (!soil_at(scene_, x) && up.dot(x) <= face.head->at(0.0) && is_behind(scene_, face, x)) complain(r, x);
    }
  }

  void enclosure() const {
    const auto leak = find_leak(scene_);
    if (!leak) return;
    std::string gap;
    for (const auto& [name, x] : leak->ends)
      gap += fmt::format("{}{}, where {} ends", gap.empty() ? (leak->ends.size() > 1 ? "between " : "past ") : " and ",
                         shown(x), name);
    fail("wall",
         fmt::format("water can run out at {} m{}{}; expected walls, faces or periodic sides that meet wherever "
                     "water or wet soil touches: close the gap with a [[wall]], or let the water through with "
                     "a [[water_face]]",
                     shown(leak->at), gap.empty() ? "" : ", ", gap));
  }

  /// Whether x lies outside the box around everything in the case.
  [[nodiscard]] bool outside(const Point3& x) const {
    const int dimension = scene_.general.dimension;
    Point3 lower = Point3::Constant(HUGE_VAL), upper = -lower;
    const auto enclose = [&](const Point3& point) {
      lower = lower.cwiseMin(point);
      upper = upper.cwiseMax(point);
    };
    const auto shape_corners = [&](const Shape& s) {
      const auto [lo, hi] = bounds(s);
      enclose(lo);
      enclose(hi);
    };
    for (const auto& soil : scene_.soils) shape_corners(soil.shape);
    for (const auto& region : scene_.fluid.regions) shape_corners(region);
    for (const auto& wall : scene_.walls) {
      for (const auto& point : wall.face.points) enclose(point);
      if (wall.shape) shape_corners(*wall.shape);
    }
    for (const auto& face : scene_.water_faces)
      for (const auto& point : face.face.points) enclose(point);
    // A plane has no ends that could enlarge the box: the domain extends beyond the box up to the plane.
    const auto plane_beyond = [&](const Point3& direction) {
      const auto closes = [&](const Face& f) {
        return f.points.empty() && f.normal.dot(direction) < 0.0 && f.normal.dot(x - f.point) >= 0.0;
      };
      return std::any_of(scene_.walls.begin(), scene_.walls.end(), [&](const Wall& w) { return closes(w.face); }) ||
             std::any_of(scene_.water_faces.begin(), scene_.water_faces.end(),
                         [&](const WaterFace& f) { return closes(f.face); });
    };
    for (int d = 0; d < dimension; ++d) {
      const double slack = 1e-6 * (upper[d] - lower[d]);
      if (x[d] < lower[d] - slack && !plane_beyond(-Point3::Unit(d))) return true;
      if (x[d] > upper[d] + slack && !plane_beyond(Point3::Unit(d))) return true;
    }
    return false;
  }

  void factor_of_safety(const Gauge& gauge, const std::string& key) const {
    if (const auto lack = lacks_strength(scene_)) fail(key + ".kind", lack->first + ": " + lack->second);
    if (!(gauge.every > 0.0)) fail(key + ".every", "expected a time between readings above 0 s, found none");
  }

  void gauges() const {
    for (std::size_t i = 0; i < scene_.gauges.size(); ++i) {
      const auto& gauge = scene_.gauges[i];
      const std::string key = fmt::format("gauge[{}]", i);
      // The name stands in a cell of gauges.csv, which simple readers must be able to split at commas.
      const auto control = [](unsigned char c) { return c < 0x20 || c == 0x7f; };
      std::string visible = gauge.name;
      std::replace_if(visible.begin(), visible.end(), control, '?');
      if (visible != gauge.name || visible.find_first_of(",\"") != std::string::npos)
        fail(key + ".name", fmt::format("expected a name without commas, quotes, line breaks and other control "
                                        "characters, for it stands in gauges.csv; found '{}'",
                                        visible));
      known_word(key + ".phase", gauge.phase, phases);
      std::vector<std::string_view> kinds;
      for (const auto& kind : gauge_kinds)
        if (kind.phase == "either" || kind.phase == gauge.phase) kinds.push_back(kind.name);
      known_word(key + ".kind", gauge.kind, kinds);
      if (gauge.phase == "fluid" && !scene_.has_water())
        fail(key + ".phase", "expected \"solid\": without water there is no fluid phase to measure");
      if (gauge.phase == "solid" && !scene_.deformable())
        fail(key + ".phase", "expected \"fluid\": with solid.model = \"rigid\" there is no solid phase to measure");
      if (gauge.kind == "point") {
        const auto known = point_quantities(gauge.phase, scene_.general.dimension);
        known_word(key + ".quantity", gauge.quantity, std::vector<std::string_view>(known.begin(), known.end()));
      }
      if (gauge.kind == "momentum" && !gauge.quantity.empty()) {
        std::vector<std::string_view> known{"momentum_x", "momentum_y"};
        if (scene_.general.dimension == 3) known.emplace_back("momentum_z");
        known_word(key + ".quantity", gauge.quantity, known);
      }
      if (gauge.kind == "factor_of_safety") factor_of_safety(gauge, key);
      if ((gauge.kind == "point" || gauge.kind == "height") && gauge.points.empty())
        fail(key + ".points", fmt::format("a {} gauge needs 1 point or more", gauge.kind));
      const bool of_face = gauge.kind == "discharge" && scene_.is_field() && !gauge.quantity.empty();
      const bool section = gauge.kind == "discharge" && scene_.is_field() && scene_.general.dimension == 3 && !of_face;
      if (section) flat_section(gauge, key + ".points");
      const bool line =
          std::find(line_kinds.begin(), line_kinds.end(), gauge.kind) != line_kinds.end() && !of_face && !section;
      if (line && (gauge.points.size() != 2 || gauge.points[0] == gauge.points[1]))
        fail(key + ".points",
             fmt::format("a gauge of kind \"{}\" needs the 2 ends of its line, found {}", gauge.kind,
                         gauge.points.size() == 2 ? "one point twice" : fmt::format("{} points", gauge.points.size())));
      const bool in_space = gauge.kind == "front" || (gauge.kind == "exit_height" && scene_.is_field());
      if (line && !in_space && scene_.general.dimension != 2)
        fail(key + ".kind", fmt::format("\"{}\" is for dimension = 2", gauge.kind));
      // Water particles have images behind walls, whose pressure would be read there.
      if (gauge.kind == "pressure_force" && !scene_.is_field())
        for (const Point3& end : gauge.points)
          if (outside(end))
            fail(key + ".points",
                 fmt::format("expected a line within the walls, soil and water of the case, found {} m "
                             "outside all of them",
                             shown(end)));
      if (gauge.kind == "heave" && !scene_.general.gravity.isZero()) {
        const Point3 up = -scene_.general.gravity.normalized(), along = gauge.points[1] - gauge.points[0];
        const double width = (along - up.dot(along) * up).norm();
        if (width < scene_.fluid.particle_spacing)
          fail(key + ".points",
               fmt::format("above a line that is {:.3g} m wide, seen from above, lies no weight to compare: expected "
                           "a line across the soil, at least a particle spacing ({} m) wide",
                           width, scene_.fluid.particle_spacing));
      }
      if ((gauge.kind == "exit_gradient" || gauge.kind == "exit_height") && scene_.general.dimension == 2)
        of_a_face(gauge, key + ".points");
      if (gauge.kind == "slip_surface" && gauge.points.size() != 4)
        fail(key + ".points",
             fmt::format("a slip surface is looked for between two lines: expected the 2 ends of each, "
                         "found {} points",
                         gauge.points.size()));
      const bool of_well =
          !gauge.quantity.empty() && std::any_of(scene_.wells.begin(), scene_.wells.end(),
                                                 [&](const Well& well) { return well.name == gauge.quantity; });
      if (gauge.kind == "basin" || ((gauge.kind == "level" || gauge.kind == "passed_volume" || of_face) && !of_well)) {
        const auto& faces = scene_.water_faces;
        const auto named = std::find_if(faces.begin(), faces.end(),
                                        [&](const WaterFace& face) { return face.name == gauge.quantity; });
        if (named == faces.end() && !(gauge.quantity.empty() && gauge.kind == "passed_volume")) {
          std::vector<std::string_view> names;
          for (const auto& face : faces)
            if (!face.name.empty()) names.push_back(face.name);
          for (const auto& well : scene_.wells)
            if (!well.name.empty()) names.push_back(well.name);
          if (!names.empty()) known_word(key + ".quantity", gauge.quantity, names);
          fail(key + ".quantity",
               fmt::format("expected the name of a [[water_face]], found \"{}\": none has a name", gauge.quantity));
        }
        if (gauge.kind == "basin" && !named->basin_area)
          fail(key + ".quantity",
               fmt::format("expected the name of a face with a 'basin_area', found \"{}\"", gauge.quantity));
        if (gauge.kind == "level" && !named->discharge && !named->head)
          fail(key + ".quantity", fmt::format("the face \"{}\" has no water level", gauge.quantity));
      }
      if (gauge.kind == "plate") {
        std::vector<std::string_view> names;
        for (const auto& plate : scene_.plates)
          if (!plate.name.empty()) names.push_back(plate.name);
        if (names.empty()) fail(key + ".quantity", "expected the name of a [[plate]]: none has a name");
        known_word(key + ".quantity", gauge.quantity, names);
      }
      if ((gauge.kind == "extent" || gauge.kind == "spread") && gauge.points.size() != 2)
        fail(key + ".points", fmt::format("expected the start of a direction and a second point on it, found {} points",
                                          gauge.points.size()));
      if (!gauge.points.empty() &&
          std::all_of(gauge.points.begin(), gauge.points.end(), [&](const Point3& x) { return outside(x); }))
        fail(
            key + ".points",
            fmt::format("expected a place within the walls, soil and water of the case, found {} m outside all of them",
                        shown(gauge.points.front())));
      if (gauge.region) {
        shape(*gauge.region, key + ".region", 0.0);
        if (beyond(*gauge.region))
          fail(key + ".region", "expected a region within the walls, soil and water of the case, found one outside");
      }
      for (std::size_t j = 0; j < scene_.gauges.size(); ++j) {
        const std::string& other = scene_.gauges[j].name;
        if (j < i && other == gauge.name)
          fail(key + ".name", fmt::format("expected a name of its own, found \"{}\" twice", gauge.name));
        if (j != i && is_series_of(gauge.name, scene_.gauges[j]))
          fail(key + ".name",
               fmt::format("expected a name of its own, found \"{}\", under which a series of gauge[{}], "
                           "\"{}\", stands in gauges.csv",
                           gauge.name, j, other));
      }
    }
  }

  /// Whether a gauge writes a series of this name, made of its own name and an ending.
  static bool is_series_of(const std::string& name, const Gauge& gauge) {
    if (!name.starts_with(gauge.name) || name == gauge.name) return false;
    const std::string ending = name.substr(gauge.name.size());
    constexpr std::array endings{std::string_view("_x"),        std::string_view("_y"),
                                 std::string_view("_z"),        std::string_view("_in"),
                                 std::string_view("_out"),      std::string_view("_stored"),
                                 std::string_view("_error"),    std::string_view("_at"),
                                 std::string_view("_along"),    std::string_view("_displacement"),
                                 std::string_view("_moment"),   std::string_view("_rotation"),
                                 std::string_view("_touching"), std::string_view("_over_critical")};
    return std::ranges::find(endings, ending) != endings.end() || (ending.front() == '[' && ending.back() == ']');
  }

  /// Whether a shape lies outside everything in the case.
  [[nodiscard]] bool beyond(const Shape& s) const {
    const auto [low, high] = bounds(s);
    Point3 lower = Point3::Constant(HUGE_VAL), upper = -lower;
    const auto enclose = [&](const Point3& x) {
      lower = lower.cwiseMin(x);
      upper = upper.cwiseMax(x);
    };
    const auto enclose_shape = [&](const Shape& other) {
      enclose(bounds(other).first);
      enclose(bounds(other).second);
    };
    for (const auto& soil : scene_.soils) enclose_shape(soil.shape);
    for (const auto& region : scene_.fluid.regions) enclose_shape(region);
    for (const auto& wall : scene_.walls) {
      if (wall.shape) enclose_shape(*wall.shape);
      if (!wall.shape && wall.face.points.empty()) return false;  // a plane goes on without end
      for (const auto& x : wall.face.points) enclose(x);
    }
    const int d = scene_.general.dimension;
    return ((low - upper).head(d).array() > 0.0).any() || ((lower - high).head(d).array() > 0.0).any();
  }

  /// Refuses a reading of a face whose soil does not lie to the left of the line: it would be taken outside the soil.
  void of_a_face(const Gauge& gauge, const std::string& key) const {
    bool left = false, right = false;
    for (const auto& place : places_on({gauge.points[0], gauge.points[1]})) {
      left = left || soil_at(scene_, place.left);
      right = right || soil_at(scene_, place.right);
    }
    if (left) return;
    if (right)
      fail(key, fmt::format("the soil lies to the right of the walk from {} to {} m; expected it on the left: turn the "
                            "order of the points round",
                            shown(gauge.points[0]), shown(gauge.points[1])));
    if (gauge.kind == "exit_gradient")
      fail(key, fmt::format("no soil lies beside the line from {} to {} m; expected a face of the soil",
                            shown(gauge.points[0]), shown(gauge.points[1])));
  }

  void flat_section(const Gauge& gauge, const std::string& key) const {
    constexpr const char* expected =
        "in 3D a discharge is read of a face or well ('quantity'), or through a flat "
        "section; expected 3 'points' or more, its corners in order";
    if (gauge.points.size() < 3) fail(key, fmt::format("{}, found {}", expected, gauge.points.size()));
    const FlatSection section(gauge.points);
    const double dx = scene_.fluid.particle_spacing;
    if (!(section.area() > 1e-9 * dx * dx)) fail(key, fmt::format("{}, found points on a line", expected));
    if (section.unevenness() > 1e-3 * dx)
      fail(key, fmt::format("{}; found corners up to {:.3g} m off a plane", expected, section.unevenness()));
  }

  void known_word(const std::string& key, const std::string& found, std::span<const std::string_view> words) const {
    if (std::find(words.begin(), words.end(), found) != words.end()) return;
    std::string list;
    for (const auto word : words) list += fmt::format("{}\"{}\"", list.empty() ? "" : ", ", word);
    fail(key, fmt::format("expected one of {}, found \"{}\"; did you mean \"{}\"?", list, found,
                          nearest(found, std::vector<std::string>(words.begin(), words.end()))));
  }
};

}  // namespace

void check_case(const Case& scene, const Places& places) { Checker(scene, places).all(); }

}  // namespace poretwin
