#include "common/case/doubts.hpp"

#include "common/case/amounts.hpp"
#include "common/case/complaints.hpp"
#include "common/case/materials.hpp"
#include "common/case/wall_edges.hpp"
#include "common/geometry/extent.hpp"
#include "common/geometry/pieces.hpp"
#include "common/geometry/shapes.hpp"
#include "common/geometry/soil_surface.hpp"
#include "common/geometry/thin_walls.hpp"
#include "common/media/seepage.hpp"
#include "common/particles/neighbours.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace poretwin {
namespace {

class Doubts : Complaints {
 public:
  Doubts(const Case& scene, const Places& places) : Complaints(scene, places), d_(scene.general.dimension) {
    const double g = scene.general.gravity.norm();
    if (g > 0.0) up_ = -scene.general.gravity / g;
  }

  std::vector<std::string> all() {
    gravity();
    units();
    other_measures();
    tables_after_the_end();
    idle_pore_pressures();
    own_weight();
    rows_at_an_angle();
    for (auto& line : doubtful_wall_edges(scene_, places_)) lines_.push_back(std::move(line));
    if (scene_.has_water()) faces_never_wet();
    if (scene_.has_water() && !scene_.has_field()) {
      no_water();
      piles_of_one_row();
      faces_that_end_on_walls();
      narrow_water();
      settling_faces();
    }
    if (scene_.is_both()) narrow_water();
    if (!scene_.has_field()) few_rows();
    if (scene_.is_field() && d_ == 3) faces_that_end_in_soil();
    loose_tolerance();
    without_effect();
    return std::move(lines_);
  }

 private:
  void doubt(const std::string& key, const std::string& message) { lines_.push_back(said(key, message)); }

  void gravity() {
    if (scene_.general.gravity[d_ - 1] > 0.0)
      doubt("case.gravity", fmt::format("points upwards, {}; expected a negative component along {}",
                                        shown(scene_.general.gravity - scene_.general.origin), "xyz"[d_ - 1]));
  }

  void units() {
    constexpr double lightest = 100.0, fastest = 1.0;
    if (scene_.has_water() && scene_.water.density < lightest)
      doubt("water.density",
            fmt::format("{} kg/m3 is lighter than any water; density is in kg/m3", scene_.water.density));
    for (std::size_t i = 0; i < scene_.soils.size(); ++i) {
      const Soil& soil = scene_.soils[i];
      const std::string key = fmt::format("soil[{}]", i);
      if (soil.grain_density < lightest)
        doubt(key + ".grain_density",
              fmt::format("{} kg/m3 is lighter than any grains; grain_density is in kg/m3", soil.grain_density));
      // Rockfill may have a larger k, since its quadratic resistance limits the flow.
      const auto seepage = porous::seepage_at(scene_, soil, soil.porosity);
      if (scene_.has_water() && seepage.quadratic == 0.0 && seepage.conductivity > fastest)
        doubt(key + ".hydraulic_conductivity",
              fmt::format("{:.3g} m/s is more than gravel has; hydraulic_conductivity is in m/s, and faster seepage is "
                          "not linear (\"forchheimer\", \"ergun\")",
                          seepage.conductivity));
    }
  }

  /// Numbers that are plausible in other units or as other measures only.
  void other_measures() {
    constexpr double radians = 1.6, steepest = 1.5, largest_ratio = 10.0, heaviest_rain = 1e-3, coarse = 0.1;
    const auto in_degrees = [&](const std::string& key, double angle) {
      if (angle > 0.0 && angle < radians && given(key))
        doubt(key, fmt::format("{:g} degrees are next to no friction; angles are in degrees", angle));
    };
    double size = 0.0;  // m, of the soil
    for (const Soil& soil : scene_.soils) {
      const auto [low, high] = bounds(soil.shape);
      size = std::max(size, (high - low).head(d_).maxCoeff());
    }
    for (std::size_t i = 0; i < scene_.soils.size(); ++i) {
      const Soil& soil = scene_.soils[i];
      const std::string key = fmt::format("soil[{}]", i);
      if (scene_.deformable() && material(scene_.model_of(soil)).has_cone())
        in_degrees(key + ".friction_angle", soil.friction_angle);
      if (soil.earth_pressure_at_rest && *soil.earth_pressure_at_rest > largest_ratio)
        doubt(key + ".earth_pressure_at_rest",
              fmt::format("the horizontal stress is {:g} times the vertical one; earth_pressure_at_rest is a ratio",
                          *soil.earth_pressure_at_rest));
      for (const char* friction : {"static_friction", "limiting_friction"})
        if (given(key + "." + friction) && soil.own(friction) > steepest)
          doubt(fmt::format("{}.{}", key, friction),
                fmt::format("{:g} is the tangent of {:.0f} degrees; {} is a ratio of stresses, not an angle",
                            soil.own(friction), std::atan(soil.own(friction)) * 180.0 / std::numbers::pi, friction));
      if (given(key + ".grain_diameter") && soil.own("grain_diameter") > coarse * size)
        doubt(key + ".grain_diameter", fmt::format("a grain is {:g} m large, the soil {:g} m; grain_diameter is in m",
                                                   soil.own("grain_diameter"), size));
      if (given(key + ".overconsolidation_ratio") && soil.own("preconsolidation_pressure") > 0.0)
        doubt(key + ".overconsolidation_ratio", "has no effect: preconsolidation_pressure takes its place");
    }
    for (std::size_t w = 0; w < scene_.walls.size(); ++w)
      in_degrees(fmt::format("wall[{}].friction_angle", w), scene_.walls[w].friction_angle);
    for (std::size_t i = 0; i < scene_.rains.size(); ++i)
      if (scene_.rains[i].rate)
        for (const auto& [time, rate] : scene_.rains[i].rate->knots)
          if (std::abs(rate) > heaviest_rain) {
            doubt(fmt::format("rain[{}].rate", i),
                  fmt::format("{:g} m/s are {:.3g} mm per hour, more than any rain; rate is in m/s", rate,
                              3.6e6 * std::abs(rate)));
            break;
          }
    if (const auto& quiet = scene_.solid.quiet; quiet && quiet->sleep_below > quiet->wake_above)
      doubt("solid.quiet.sleep_below",
            fmt::format("soil goes to sleep at a larger departure from rest, {:g} g, than the change of force, {:g} g, "
                        "that wakes it; expected less",
                        quiet->sleep_below, quiet->wake_above));
  }

  /// Tables in time of which only the first value ever counts.
  void tables_after_the_end() {
    const double end = scene_.general.end_time;
    const auto look = [&](const std::string& key, const std::optional<Series>& series) {
      if (series && series->knots.size() > 1 && series->knots.front().first >= end)
        doubt(key, fmt::format("begins at {:g} s, when the run has ended ({:g} s): its first value, {:g}, holds "
                               "throughout; times are in s",
                               series->knots.front().first, end, series->knots.front().second));
    };
    for (std::size_t i = 0; i < scene_.water_faces.size(); ++i) {
      const WaterFace& f = scene_.water_faces[i];
      const std::string key = fmt::format("water_face[{}]", i);
      look(key + ".head", f.head);
      look(key + ".pressure", f.pressure);
      look(key + ".discharge", f.discharge);
      look(key + ".basin_rain", f.basin_rain);
      look(key + ".wave_amplitude", f.wave_amplitude);
    }
    for (std::size_t i = 0; i < scene_.rains.size(); ++i) look(fmt::format("rain[{}].rate", i), scene_.rains[i].rate);
    for (std::size_t i = 0; i < scene_.wells.size(); ++i) {
      look(fmt::format("well[{}].discharge", i), scene_.wells[i].discharge);
      look(fmt::format("well[{}].head", i), scene_.wells[i].head);
    }
    for (std::size_t i = 0; i < scene_.loads.size(); ++i)
      look(fmt::format("load[{}].factor", i), scene_.loads[i].factor);
    for (std::size_t i = 0; i < scene_.plates.size(); ++i) {
      const Plate& plate = scene_.plates[i];
      const std::string key = fmt::format("plate[{}]", i);
      look(key + ".displacement", plate.displacement);
      look(key + ".speed", plate.speed);
      look(key + ".force", plate.force);
      look(key + ".along", plate.along);
      look(key + ".moment", plate.moment);
    }
    for (std::size_t i = 0; i < scene_.pore_pressures.size(); ++i) {
      look(fmt::format("pore_pressure[{}].head", i), scene_.pore_pressures[i].head);
      look(fmt::format("pore_pressure[{}].pressure", i), scene_.pore_pressures[i].pressure);
    }
  }

  /// Pore pressures that act on no soil: their region holds none, or an earlier one is everywhere.
  void idle_pore_pressures() {
    bool everywhere = false;
    for (std::size_t i = 0; i < scene_.pore_pressures.size(); ++i) {
      const PorePressure& p = scene_.pore_pressures[i];
      const std::string key = fmt::format("pore_pressure[{}]", i);
      if (everywhere) doubt(key, "has no effect: an earlier one without a region holds in all soil");
      everywhere = everywhere || !p.region;
      const bool met = !p.region || std::ranges::any_of(scene_.soils, [&](const Soil& soil) {
        return std::ranges::any_of(places_in(soil.shape, scene_.solid.particle_spacing, d_),
                                   [&](const Point3& x) { return contains(*p.region, x, d_); });
      });
      if (!met) doubt(key + ".region", "has no effect: no soil lies in it");
    }
  }

  void own_weight() {
    if (!scene_.deformable() || up_.isZero()) return;
    double bottom = HUGE_VAL, top = -HUGE_VAL;
    for (const auto& soil : scene_.soils) {
      const auto [lowest, highest] = extent(soil.shape, up_, d_);
      bottom = std::min(bottom, lowest);
      top = std::max(top, highest);
    }
    constexpr double most = 0.05;
    for (std::size_t i = 0; i < scene_.soils.size(); ++i) {
      const Soil& soil = scene_.soils[i];
      const double density = (1.0 - soil.porosity) * soil.grain_density;
      const double strain =
          density * scene_.general.gravity.norm() * (top - bottom) / constrained_modulus(scene_, soil);
      if (strain > most)
        doubt(
            fmt::format("soil[{}].youngs_modulus", i),
            fmt::format("the weight of {:.3g} m of soil strains it by {:.3g} % (rho g H / M), expected {:g} % at most; "
                        "youngs_modulus is in Pa, found {:g}",
                        top - bottom, 100.0 * strain, 100.0 * most, soil.youngs_modulus));
    }
  }

  /// Warns of a drained face from which elastic soil settles under a load: with water as particles the face stays where
  /// it is drawn. Error of the degree of consolidation at settlements of 0.02, 0.1, 0.2, 0.4 and 0.8 spacings:
  /// 0.7, 1.4, 1.8, 2.7 and 6.9 % (20 and 40 rows). A field is 0.4 % off.
  void settling_faces() {
    if (d_ != 2 || !scene_.coupled() || scene_.can_yield()) return;
    constexpr double most = 0.1, near = 0.05;  // spacings
    const double dx = scene_.solid.particle_spacing;
    const auto drained = [&](const Point3& x) {
      return std::ranges::any_of(scene_.water_faces, [&](const WaterFace& face) {
        const auto pieces = pieces_of(face.face);
        return std::ranges::any_of(pieces, [&](const Piece& piece) { return distance_from(piece, x) < near * dx; });
      });
    };
    for (std::size_t i = 0; i < scene_.loads.size(); ++i) {
      const Load& load = scene_.loads[i];
      if (!load.start && !load.factor) continue;  // it acts from before time zero on
      double factor = load.factor ? 0.0 : 1.0, settlement = 0.0;
      if (load.factor)
        for (const auto& [time, value] : load.factor->knots) factor = std::max(factor, value);
      for (const auto& piece : pieces_of(load.face))
        for (const auto& x : places_along(piece, dx)) {
          if (!drained(x)) continue;
          const double q = factor * (load.pressure ? *load.pressure : load.traction.dot(piece.left()));
          double here = 0.0;
          for (double depth = 0.5 * dx; const Soil* soil = soil_at(scene_, x + depth * piece.left()); depth += dx)
            here += q * dx / constrained_modulus(scene_, *soil);
          settlement = std::max(settlement, here);
        }
      if (settlement < most * dx) continue;
      doubt(fmt::format("load[{}]", i),
            fmt::format("settles the soil by some {:.2g} m, {:.2g} spacings, while the drained face stays where it is "
                        "drawn: the degree of consolidation is 1.4 % off at 0.1 spacings, 3 % at 0.4, 7 % at 0.8; "
                        "expected fluid.representation = \"field\", or a larger particle_spacing",
                        settlement, settlement / dx));
    }
  }

  /// Rows of particles lie along x and y, or along the sides of a rectangle. Where a wall cuts the rows at an angle,
  /// they end at varying distances from it, and stresses are wrong. Errors measured in elastic soil under its own
  /// weight, 20 rows high, on walls at 6, 17, 34 and 45 degrees, relative to the stress at the base: 20 to 40 % on the
  /// wall, 3 to 16 % three rows from it, 1 to 9 % six rows from it.
  void rows_at_an_angle() {
    if (!scene_.deformable() || d_ != 2) return;
    const double dx = scene_.solid.particle_spacing;
    constexpr double parallel = 0.02, shortest = 3.0;  // sine of the angle; spacings
    for (std::size_t w = 0; w < scene_.walls.size(); ++w) {
      if (scene_.walls[w].soil == Wall::ForSoil::none) continue;
      for (const auto& piece : pieces_of(scene_.walls[w].face)) {
        const Point3 along = (piece.b - piece.a).normalized();
        if (std::min(std::abs(along.x()), std::abs(along.y())) < parallel) continue;
        for (std::size_t i = 0; i < scene_.soils.size(); ++i) {
          if (turned_rectangle(scene_.soils[i].shape)) continue;
          double touching = 0.0;
          const auto places = places_along(piece, 0.5 * dx);
          for (const auto& x : places)
            if (contains(scene_.soils[i].shape, x + 0.25 * dx * piece.left(), 2))
              touching += piece.length() / static_cast<double>(places.size());
          if (touching < shortest * dx) continue;
          doubt(fmt::format("wall[{}]", w),
                fmt::format("{} lies along it at an angle to the rows of its particles, and stresses near it are off: "
                            "by up to 40 % of rho g H on it, 16 % three rows from it; expected a wall along x or y, "
                            "with case.gravity turned instead, or soil drawn as a rectangle",
                            named("soil", i, scene_.soils[i].name)));
          return;
        }
      }
    }
  }

  /// At the end of a sheet pile the exact velocity is unbounded, and the particles there are disordered. The computed
  /// seepage under the pile (30 rows, compared with finite volumes) is 1 % low for a pile 2 or 4 spacings thick, 4 %
  /// low for one 1 spacing thick, and 3 % low for a pile that is a line.
  void piles_of_one_row() {
    if (hinders_sight(scene_, Keeps::water)) return;
    const double dx = scene_.fluid.particle_spacing;
    for (const auto& thin : thin_walls(scene_, Keeps::water)) {
      const bool in_soil = soil_at(scene_, thin.at) || soil_at(scene_, thin.at + 0.5 * dx * Point3::UnitX()) ||
                           soil_at(scene_, thin.at + 0.5 * dx * Point3::UnitY());
      if (!thin.both_sides || !in_soil || thin.thickness > 1.5 * dx) continue;
      doubt(
          fmt::format("wall[{}]", thin.wall),
          fmt::format("{} in soil: the flow past its end is 3 to 4 % low with 30 rows around it; expected, for 1 %, a "
                      "wall at least 2 particle spacings thick",
                      thin.thickness == 0.0 ? "is one line" : "is a particle spacing thick"));
      return;
    }
  }

  /// The exact velocity is unbounded at the end of a face of soil if a wall continues from there in the same direction
  /// or turns away from the soil. The computed flow through such a face is low unless it is taken from the matrix of
  /// the pressure solve. Measured against finite volumes: with 10, 20 and 40 spacings of face on half of a side, 22, 9
  /// and 4.3 % low; below an impermeable floor 40 spacings long, on a layer 30 spacings thick, 12 % low, and 6 % with
  /// half the spacing. Inflow and outflow differ by as much.
  void faces_that_end_on_walls() {
    if (d_ != 2 || (!scene_.coupled() && scene_.fluid.scheme == FluidCase::Scheme::projection &&
                    porous::conductivity_contrast(scene_) < porous::one_conductivity))
      return;
    const double dx = scene_.fluid.particle_spacing;
    for (std::size_t i = 0; i < scene_.water_faces.size(); ++i) {
      const WaterFace& f = scene_.water_faces[i];
      const auto pieces = pieces_of(f.face);
      if (pieces.empty() || f.outlet) continue;
      for (const auto& [piece, end, inner] : {std::tuple{pieces.front(), pieces.front().a, pieces.front().b},
                                              std::tuple{pieces.back(), pieces.back().b, pieces.back().a}}) {
        const Point3 before = end + 0.25 * dx * (piece.left() + (inner - end).normalized());
        if (!soil_at(scene_, before)) continue;
        for (std::size_t w = 0; w < scene_.walls.size(); ++w) {
          if (scene_.walls[w].water == Wall::ForWater::none) continue;
          const auto sides = pieces_of(scene_.walls[w].face);
          if (sides.empty()) continue;
          for (const auto& [at, other] :
               {std::pair{sides.front().a, sides.front().b}, std::pair{sides.back().b, sides.back().a}}) {
            constexpr double same_place = 0.05, straight = 0.01;  // spacings; sine of the angle
            if ((at - end).norm() > same_place * dx || (other - at).normalized().dot(piece.left()) > straight) continue;
            doubt(fmt::format("water_face[{}]", i),
                  fmt::format("{} goes straight on where it ends, and the flow through its end is low: by 22 % with 10 "
                              "spacings along the face, 9 % with 20, 4 % with 40, and what comes in and goes out "
                              "differs by as much; it has {:.2g}: expected a smaller fluid.particle_spacing",
                              named("wall", w, scene_.walls[w].name), (inner - end).norm() / dx));
            return;
          }
        }
      }
    }
  }

  /// Warns of a face that is never wetted: its head stays below its lowest point.
  void faces_never_wet() {
    if (up_.isZero()) return;
    const double dx = scene_.fluid.particle_spacing;
    for (std::size_t i = 0; i < scene_.water_faces.size(); ++i) {
      const WaterFace& f = scene_.water_faces[i];
      if (!f.head || f.discharge || f.face.points.empty()) continue;
      double lowest = HUGE_VAL, highest = -HUGE_VAL;
      for (const auto& x : f.face.points) lowest = std::min(lowest, up_.dot(x));
      for (const auto& [time, value] : f.head->knots) highest = std::max(highest, value);
      if (highest < lowest - dx)
        doubt(
            fmt::format("water_face[{}].head", i),
            fmt::format("never wets the face: it is {:g} m at most, the face's lowest point lies at {:g} m; a head is "
                        "an elevation, not a depth",
                        highest, lowest));
    }
  }

  void no_water() {
    if (up_.isZero()) return;
    const bool comes_in = std::any_of(scene_.water_faces.begin(), scene_.water_faces.end(), [&](const WaterFace& f) {
      if (f.pressure || f.discharge || f.face.points.empty()) return !f.outlet;
      if (!f.head) return false;
      double lowest = HUGE_VAL;
      for (const auto& x : f.face.points) lowest = std::min(lowest, up_.dot(x));
      return std::any_of(f.head->knots.begin(), f.head->knots.end(), [&](const auto& k) { return k.second > lowest; });
    });
    if (scene_.fluid.regions.empty() && !comes_in)
      doubt("water_face",
            "no water is there and none ever comes in: expected a [[fluid.region]], or a face with a head "
            "above its lowest point, a pressure or a discharge");
  }

  void narrow_water() {
    if (d_ != 2) return;
    const double dx = scene_.fluid.particle_spacing;
    constexpr double fewest = 4.0;
    struct Side {
      std::size_t wall;
      Piece piece;
    };
    std::vector<Side> sides;
    for (std::size_t i = 0; i < scene_.walls.size(); ++i)
      if (scene_.walls[i].water != Wall::ForWater::none)
        for (const auto& piece : pieces_of(scene_.walls[i].face)) sides.push_back({i, piece});
    for (std::size_t p = 0; p < sides.size(); ++p)
      for (std::size_t q = p + 1; q < sides.size(); ++q) {
        const Point3 left = sides[p].piece.left();
        if (left.dot(sides[q].piece.left()) > -0.9) continue;
        for (const auto& x : places_along(sides[p].piece, dx)) {
          const auto width = distance_to(sides[q].piece, x, left);
          if (!width || !(*width > 0.0) || *width >= (1.0 - 1e-6) * fewest * dx) continue;
          doubt(fmt::format("wall[{}]", sides[q].wall),
                fmt::format(
                    "leaves {:.3g} m for water beside {} at {} m, {:.2g} particles; expected {:g} or more: give a "
                    "fluid.particle_spacing of {:.3g} m or less",
                    *width, named("wall", sides[p].wall, scene_.walls[sides[p].wall].name), shown(x), *width / dx,
                    fewest, *width / fewest));
          return;
        }
      }
  }

  void few_rows() {
    const double dx = scene_.deformable() ? scene_.solid.particle_spacing : scene_.fluid.particle_spacing;
    constexpr double fewest = 5.0;
    for (std::size_t i = 0; i < scene_.soils.size(); ++i) {
      const Soil& soil = scene_.soils[i];
      const auto [lower, upper] = bounds(soil.shape);
      double least = HUGE_VAL;
      for (int d = 0; d < d_; ++d)
        if (std::find(scene_.general.periodic.begin(), scene_.general.periodic.end(), d) ==
            scene_.general.periodic.end())
          least = std::min(least, upper[d] - lower[d]);
      if (!(least < (fewest - 0.5) * dx) || goes_on(i, dx)) continue;
      doubt(fmt::format("soil[{}]", i),
            fmt::format("is {:.3g} m thin, {:.2g} rows of particles; expected {:g} or more: give a particle_spacing of "
                        "{:.3g} m or less",
                        least, std::round(least / dx), fewest, least / fewest));
    }
  }
  /// Whether another region of the same soil touches this one, so that both are one layer.
  [[nodiscard]] bool goes_on(std::size_t i, double dx) const {
    const Soil& soil = scene_.soils[i];
    const auto [lower, upper] = bounds(soil.shape);
    for (std::size_t j = 0; j < scene_.soils.size(); ++j) {
      const Soil& other = scene_.soils[j];
      if (i == j || other.hydraulic_conductivity != soil.hydraulic_conductivity ||
          other.anisotropy != soil.anisotropy || other.porosity != soil.porosity ||
          other.youngs_modulus != soil.youngs_modulus)
        continue;
      const auto [low, high] = bounds(other.shape);
      const Eigen::Array3d gap = (low - upper).cwiseMax(lower - high).array();
      if ((gap.head(d_) <= 0.5 * dx).all()) return true;
    }
    return false;
  }

  /// Warns of narrow faces of a field in 3D that end beside soil without a face, on flat ground or at an inward edge.
  /// The exact velocity is unbounded at such an end, and the discharge converges only at first order.
  void faces_that_end_in_soil() {
    const double dx = scene_.fluid.particle_spacing;
    if (!(dx > 0.0) || scene_.water_faces.empty()) return;
    constexpr double beside = 1e-3, next = 1.5, parallel = 0.9, inwards = 0.1, level = 0.99;
    constexpr double wide = 20.0;  // spacings, half the width; wider faces lack about 3 % of their discharge or less
    const SoilSurface surface(scene_, dx);
    VecArray<3> bare, bare_normals;
    std::vector<VecArray<3>> wet(scene_.water_faces.size()), normals(wet.size());
    for (const auto& place : surface.places(dx)) {
      bool covered = std::ranges::any_of(scene_.rains,
                                         [&](const Rain& rain) { return lies_along(rain.face, place, beside * dx); });
      for (std::size_t i = 0; i < wet.size(); ++i) {
        if (!lies_along(scene_.water_faces[i].face, place, beside * dx)) continue;
        covered = true;
        wet[i].push_back(place.at);
        normals[i].push_back(place.outwards);
      }
      if (covered) continue;
      bare.push_back(place.at);
      bare_normals.push_back(place.outwards);
    }
    if (bare.empty()) return;
    // A strip without a face that is narrower than half a spacing, as often remains beside a plane of symmetry, has no
    // cells of its own: around such a place the surface continues without the face in two of the directions only.
    const auto goes_on = [&](const SoilSurface::Place& from, const Face& face) {
      const Point3 u = from.outwards.unitOrthogonal(), v = from.outwards.cross(u);
      constexpr int directions = 8, enough = 3;
      int count = 0;
      for (int k = 0; k < directions; ++k) {
        const double angle = 2.0 * std::numbers::pi * k / directions;
        const SoilSurface::Place place{from.at + 0.5 * dx * (std::cos(angle) * u + std::sin(angle) * v), from.outwards};
        count += surface.is_border(place.at, place.outwards) && !lies_along(face, place, beside * dx);
      }
      return count >= enough;
    };
    sph::CellGrid<3> of_bare;
    of_bare.build(bare, next * dx);
    for (std::size_t i = 0; i < wet.size(); ++i) {
      const WaterFace& face = scene_.water_faces[i];
      double top = HUGE_VAL;  // elevation of the water behind the face
      if (face.head) {
        top = -HUGE_VAL;
        for (const auto& knot : face.head->knots) top = std::max(top, knot.second);
      }
      VecArray<3> ends;
      for (std::size_t k = 0; k < wet[i].size(); ++k) {
        const Point3 &x = wet[i][k], &n = normals[i][k];
        // At the upper end of a drain on a slope the soil is not full of water, so that this end does not count.
        if (face.outlet && std::abs(n.dot(up_)) < level) continue;
        of_bare.for_each_within(x, next * dx, [&](Index j, double squared) {
          const Point3 way = bare[j] - x;
          const double rise = n.dot(way) / std::sqrt(squared), back = -bare_normals[j].dot(way) / std::sqrt(squared);
          const bool flat = n.dot(bare_normals[j]) > parallel && std::abs(rise) < inwards;
          const bool turns_inwards = rise > inwards && back > inwards;
          if ((flat || turns_inwards) && up_.dot(bare[j]) < top - dx && goes_on({bare[j], bare_normals[j]}, face.face))
            ends.push_back(bare[j]);
        });
      }
      if (ends.empty()) continue;
      sph::CellGrid<3> of_ends;
      of_ends.build(ends, wide * dx);
      double half = 0.0;
      for (const Point3& x : wet[i]) {
        double least = wide * dx;
        of_ends.for_each_within(x, wide * dx,
                                [&](Index, double squared) { least = std::min(least, std::sqrt(squared)); });
        half = std::max(half, least);
      }
      if (half >= wide * dx) continue;
      doubt(fmt::format("water_face[{}]", i),
            fmt::format(
                "ends on the surface of soil without a face, near {} m, and is {:.2g} spacings wide from its middle "
                "to its end: the flow has no bound there, and its discharge may be too low (14 % with 4 spacings, "
                "11 % with 6, as measured at the base of a pit); refine, or compare two spacings",
                shown(ends.front()), half / dx));
    }
  }

  void loose_tolerance() {
    const auto& c = scene_.coupling;
    const double usual = CouplingCase{}.settled_below();
    if (!scene_.predicts() || c.scheme != CouplingCase::Scheme::iterated || c.settled_below() <= usual) return;
    doubt("coupling.tolerance",
          fmt::format("{:g} of the weight may be missing in the soil's balance after every window, and the errors add "
                      "up over the windows: with 0.005 a pressure was wrong by 7 % of the load; expected {:g} or less",
                      c.settled_below(), usual));
  }

  void without_effect() {
    const auto idle = [&](const std::string& key, bool has_none, const std::string& why) {
      if (has_none && given(key)) doubt(key, "has no effect: " + why);
    };
    const auto all_below = [&](const std::string& section, const std::string& but, const std::string& why) {
      std::string keys;
      for (auto it = places_.lower_bound(section + "."); it != places_.end() && it->first.starts_with(section + ".");
           ++it)
        if (it->first != but) keys += (keys.empty() ? "" : ", ") + it->first.substr(section.size() + 1);
      if (!keys.empty()) doubt(section, fmt::format("has no effect ({}): {}", keys, why));
    };
    const auto& f = scene_.fluid;
    const auto& s = scene_.solid;
    const bool eisph = f.scheme != FluidCase::Scheme::projection;
    if (!scene_.deformable()) all_below("solid", "solid.model", "with solid.model = \"rigid\" there is no solid phase");
    if (!scene_.has_water()) all_below("fluid", "fluid.particle_spacing", "there is no water");
    if (scene_.has_water()) {
      idle("fluid.sweeps", !eisph, "it belongs to fluid.scheme = \"eisph\"");
      idle("fluid.pressure_tolerance", eisph, "explicit sweeps have none; it belongs to fluid.scheme = \"projection\"");
      idle("fluid.pressure_tolerance", !eisph && scene_.coupled() && f.skeleton_response,
           "it holds where no skeleton responds");
      idle("fluid.seed", f.jitter == 0.0, "fluid.jitter is 0");
      for (const char* key : {"drag", "drag_form"})
        idle(std::string("fluid.") + key, scene_.soils.empty(), "there is no [[soil]]");
      idle("fluid.skeleton_response", !scene_.coupled(), "the soil does not move");
    }
    if (scene_.deformable()) {
      idle("solid.seed", s.jitter == 0.0, "solid.jitter is 0");
      idle("solid.initial_seepage", !s.initial_rest, "solid.initial_rest = false");
      idle("solid.initial_seepage", s.initial_rest && (!scene_.coupled() || !f.drag), "no water drags at the soil");
      idle("solid.strength_reduction", !scene_.can_yield(), "elastic soil does not fail");
    } else {
      for (std::size_t i = 0; i < scene_.loads.size(); ++i)
        doubt(fmt::format("load[{}]", i), "has no effect: with solid.model = \"rigid\" nothing gives way to it");
    }
    const auto too_late = [&](const std::string& key, const std::optional<double>& start) {
      const double end = scene_.general.end_time;
      if (start && *start >= end)
        doubt(key + ".start", fmt::format("has no effect: it is {:g} s, and the run ends at {:g} s", *start, end));
    };
    for (std::size_t i = 0; i < scene_.loads.size(); ++i) too_late(fmt::format("load[{}]", i), scene_.loads[i].start);
    for (std::size_t i = 0; i < scene_.plates.size(); ++i)
      too_late(fmt::format("plate[{}]", i), scene_.plates[i].start);
    for (const char* key : {"scheme", "acceleration", "tolerance", "keep_points"})
      idle(std::string("coupling.") + key, !scene_.coupled(), "one phase runs alone");
    for (const char* key : {"acceleration", "tolerance"})
      idle(std::string("coupling.") + key, scene_.coupled() && scene_.coupling.scheme != CouplingCase::Scheme::iterated,
           "it belongs to coupling.scheme = \"iterated\"");
    idle("coupling.acceleration", scene_.coupling.scheme == CouplingCase::Scheme::iterated && scene_.predicts(),
         "the fluid's prediction takes its place (fluid.skeleton_response)");
    idle("case.central_force", !scene_.has_water(), "it acts on water");
    const bool boxed = !scene_.general.periodic.empty() ||
                       (d_ == 3 && std::any_of(scene_.walls.begin(), scene_.walls.end(),
                                               [](const Wall& wall) { return wall.soil == Wall::ForSoil::rough; }));
    for (const char* key : {"domain_min", "domain_max"})
      idle(std::string("case.") + key, !boxed && !(f.initial_vortices > 0.0),
           "no axis is periodic (case.periodic), and it is no wall");
    shapes(idle);
    gauges(idle);
    for (std::size_t i = 0; i < scene_.soils.size(); ++i) {
      const std::string soil = fmt::format("soil[{}]", i);
      for (const char* key : {"model", "contact_porosity"})
        idle(soil + "." + key, !scene_.deformable(), "with solid.model = \"rigid\" no soil moves");
      const bool coulomb = scene_.model_of(scene_.soils[i]) == MaterialName::mohr_coulomb;
      idle(soil + ".cone", scene_.deformable() && coulomb, "it fits Drucker-Prager to what this model is");
      const Soil& own = scene_.soils[i];
      idle(soil + ".softening_slip",
           !own.residual_cohesion && !own.residual_friction_angle && !own.residual_dilation_angle,
           "no strength falls; expected 'residual_cohesion', 'residual_friction_angle' or 'residual_dilation_angle'");
      if (scene_.deformable()) own_numbers(idle, scene_.model_of(scene_.soils[i]), soil);
    }
  }
  /// Warns of parameters that belong to another material than that of the soil.
  template <class Idle>
  void own_numbers(const Idle& idle, MaterialName model, const std::string& soil) {
    const Material mine = material(model);
    const auto is_of_law = [](std::string_view key) {
      return std::ranges::any_of(porous::seepage_laws(), [&](const auto& law) {
        return std::ranges::any_of(law.parameters, [&](const auto& p) { return p.key == key; });
      });
    };
    for (const Material& other : materials())
      for (const MaterialKey& key : other.keys)
        idle(fmt::format("{}.{}", soil, key.name), !mine.has_key(key.name) && !is_of_law(key.name),
             fmt::format("it belongs to soil.model = \"{}\"", other.name));
    for (const char* key : {"cohesion", "friction_angle", "dilation_angle", "tensile_strength", "cone",
                            "maximum_void_ratio", "saturated_cohesion"})
      idle(fmt::format("{}.{}", soil, key), mine.strength == Material::Strength::own,
           fmt::format("soil.model = \"{}\" has a strength of its own", mine.name));
    idle(soil + ".undrained_shear_strength", !mine.has_cone(),
         fmt::format("soil.model = \"{}\" has no cohesion", mine.name));
  }
  template <class Idle>
  void shapes(const Idle& idle) {
    const auto look = [&](const Shape& s, const std::string& key) {
      using Kind = Shape::Kind;
      const bool round = s.kind == Kind::cylinder || s.kind == Kind::cone,
                 file = s.kind == Kind::mesh || s.kind == Kind::terrain;
      idle(key + ".centre", s.kind != Kind::ball && s.around.empty(), "it belongs to shape = \"ball\"");
      idle(key + ".radius", s.kind != Kind::ball && !round, "it belongs to shape = \"ball\"");
      for (const char* of_box : {".min", ".max", ".points"})
        idle(key + of_box, s.kind == Kind::ball, "a ball takes 'centre' and 'radius'");
      for (const char* of_box : {".min", ".max", ".points"})
        idle(key + of_box, round || file, "it belongs to shape = \"box\" or \"polygon\"");
      for (const char* of_polygon : {".along", ".around", ".from", ".to"})
        idle(key + of_polygon, s.kind != Kind::polygon, "it belongs to shape = \"polygon\"");
      idle(key + ".ends", !round, "it belongs to shape = \"cylinder\" or \"cone\"");
      idle(key + ".end_radius", s.kind != Kind::cone, "it belongs to shape = \"cone\"");
      idle(key + ".file", !file, "it belongs to shape = \"mesh\" or \"terrain\"");
      idle(key + ".bottom", s.kind != Kind::terrain, "it belongs to shape = \"terrain\"");
    };
    for (std::size_t i = 0; i < scene_.walls.size(); ++i)
      if (scene_.walls[i].shape) look(*scene_.walls[i].shape, fmt::format("wall[{}]", i));
    for (std::size_t i = 0; i < scene_.soils.size(); ++i) look(scene_.soils[i].shape, fmt::format("soil[{}]", i));
    for (std::size_t i = 0; i < scene_.fluid.regions.size(); ++i)
      look(scene_.fluid.regions[i], fmt::format("fluid.region[{}]", i));
  }
  template <class Idle>
  void gauges(const Idle& idle) {
    for (std::size_t i = 0; i < scene_.gauges.size(); ++i) {
      const Gauge& g = scene_.gauges[i];
      const std::string key = fmt::format("gauge[{}]", i);
      idle(key + ".quantity",
           g.kind != "point" && g.kind != "momentum" && g.kind != "level" && g.kind != "passed_volume" &&
               g.kind != "basin" && !(g.kind == "discharge" && scene_.is_field()) && g.kind != "infiltration" &&
               g.kind != "evaporation" && g.kind != "runoff" && g.kind != "plate",
           fmt::format("a gauge of kind \"{}\" reads one quantity only", g.kind));
      idle(key + ".pressure_head", g.kind != "front", "it belongs to a \"front\"");
      idle(key + ".every", g.kind != "factor_of_safety", "it belongs to \"factor_of_safety\"");
      idle(key + ".thickness", g.kind != "front" || g.phase != "solid", "it belongs to the \"front\" of the soil");
      constexpr std::array with_points{"point",        "front",          "extent", "spread",
                                       "discharge",    "exit_height",    "height", "exit_gradient",
                                       "slip_surface", "pressure_force", "heave"};
      idle(key + ".points", std::find(with_points.begin(), with_points.end(), g.kind) == with_points.end(),
           fmt::format("a gauge of kind \"{}\" is of the whole phase, or of its 'region'", g.kind));
      constexpr std::array without_region{
          "point",        "front",        "discharge",   "exit_height",   "exit_gradient",    "height",
          "slip_surface", "level",        "basin",       "passed_volume", "balance",          "received_impulse",
          "drag_work",    "infiltration", "evaporation", "runoff",        "factor_of_safety", "pressure_force",
          "heave"};
      idle(key + ".region", std::find(without_region.begin(), without_region.end(), g.kind) != without_region.end(),
           fmt::format("a gauge of kind \"{}\" knows no region", g.kind));
      if (g.kind == "pressure_force" && scene_.is_field() && g.points.size() == 2) off_the_soil(g, key);
    }
  }

  /// Warns of a line for a force of the water that leaves the soil: a field has no water there.
  void off_the_soil(const Gauge& g, const std::string& key) {
    const Piece line{g.points[0], g.points[1]};
    const double dx = scene_.fluid.particle_spacing, beside = 0.05 * dx;
    const auto places = places_along(line, 0.5 * dx);
    const auto outside = std::ranges::count_if(places, [&](const Point3& x) {
      return !soil_at(scene_, x + beside * line.left()) && !soil_at(scene_, x - beside * line.left());
    });
    const double length = line.length() * static_cast<double>(outside) / static_cast<double>(places.size());
    if (length > dx)
      doubt(key + ".points",
            fmt::format("about {:.2g} m of the line lie outside the soil, where a field has no water: they "
                        "count as without pressure",
                        length));
  }

  int d_;
  Point3 up_ = Point3::Zero();
  std::vector<std::string> lines_;
};

}  // namespace

std::vector<std::string> doubts(const Case& scene, const Places& places) { return Doubts(scene, places).all(); }

}  // namespace poretwin
