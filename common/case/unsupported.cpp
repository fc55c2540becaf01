#include "common/case/unsupported.hpp"

#include "common/case/amounts.hpp"
#include "common/case/complaints.hpp"
#include "common/case/materials.hpp"
#include "common/geometry/extent.hpp"
#include "common/geometry/loaded_part.hpp"
#include "common/geometry/pieces.hpp"
#include "common/geometry/shapes.hpp"
#include "common/geometry/thin_walls.hpp"
#include "common/media/seepage.hpp"
#include "common/particles/kernel.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

namespace poretwin {
namespace {

class Supported : Complaints {
 public:
  Supported(const Case& scene, const Places& places) : Complaints(scene, places), d_(scene.general.dimension) {
    const double g = scene.general.gravity.norm();
    if (g > 0.0) up_ = -scene.general.gravity / g;
  }

  void all() const {
    near_origin();
    if (scene_.has_water()) {
      partitions(Keeps::water);
      layers_of_few_rows();
      solid_bodies();
      heads_below_the_soils_top();
      openings_under_water();
      drains_without_pressure();
    }
    if (scene_.deformable()) {
      partitions(Keeps::soil);
      loads();
      tension();
    }
    if (scene_.coupled()) loaded_plates();
  }
  void loads_on_soil() const {
    if (scene_.deformable()) loads();
  }

 private:
  /// Refuses scenes too far from the origin. Particles are sorted into cells whose numbers have 21 bits per axis, and
  /// distances lose digits: with a spacing of 0.1 m, results are wrong farther than 2^19 m from the origin. read_case()
  /// has already moved the scene towards the origin along axes without gravity.
  void near_origin() const {
    const double spacing = finest_spacing(scene_);
    constexpr double most = 1e6;
    const auto look = [&](const Shape& s, const std::string& key) {
      const auto [lower, upper] = bounds(s);
      for (int d = 0; d < d_; ++d)
        for (const double x : {lower[d], upper[d]})
          if (std::abs(x) > most * spacing)
            fail(key, fmt::format("lies at {} = {:.6g} m, {:.2g} particle spacings from the origin; expected {:g} at "
                                  "most along gravity, central_force and initial_strain: move the scene to the origin",
                                  "xyz"[d], x + scene_.general.origin[d], std::abs(x) / spacing, most));
    };
    for (std::size_t i = 0; i < scene_.soils.size(); ++i) look(scene_.soils[i].shape, fmt::format("soil[{}]", i));
    for (std::size_t i = 0; i < scene_.fluid.regions.size(); ++i)
      look(scene_.fluid.regions[i], fmt::format("fluid.region[{}]", i));
  }

  /// Refuses thin walls through which water or soil would interact. A line of sight (`Sight`) separates the particles
  /// on the two sides of a thin wall, unless hinders_sight() names a reason why it cannot. No particle may lie too
  /// close to a wall that is a single line.
  void partitions(Keeps what) const {
    const bool water = what == Keeps::water;
    const char *const matter = water ? "water" : "soil", *const phase = water ? "fluid" : "solid";
    const double dx = water ? scene_.fluid.particle_spacing : scene_.solid.particle_spacing;
    const auto hindered = hinders_sight(scene_, what);
    for (const auto& thin : thin_walls(scene_, what)) {
      const std::string key = fmt::format("wall[{}]", thin.wall);
      if (hindered && thin.thickness == 0.0)
        fail(key, fmt::format("runs through a [[{}]], for example at {} m; a wall that is one line keeps {} apart, but "
                              "not {}: expected {} on its left side only",
                              water ? "fluid.region" : "soil", shown(thin.at), matter, *hindered, matter));
      else if (hindered)
        fail(key, fmt::format("is {:.4g} m thick at {} m, {:.2g} particle spacings, with {} on {}: particles would "
                              "interact through it {}; expected {:.4g} m or more, {:g} spacings: draw it "
                              "thicker, or give a {}.particle_spacing of {:.3g} m or less",
                              thin.thickness, shown(thin.at), thin.thickness / dx, matter,
                              thin.both_sides ? "both sides" : "one side", *hindered, thin.least, thin.least / dx,
                              phase, thin.thickness / (thin.least / dx)));
      else if (thin.thickness == 0.0)
        rows_beside(thin.wall, what);
    }
  }

  /// Refuses particles closer to a line than a quarter of a spacing, which their own images would push away from it.
  void rows_beside(std::size_t w, Keeps what) const {
    const bool water = what == Keeps::water;
    const double dx = water ? scene_.fluid.particle_spacing : scene_.solid.particle_spacing;
    const Point3& offset = water ? scene_.fluid.offset : scene_.solid.offset;
    const std::size_t n = water ? scene_.fluid.regions.size() : scene_.soils.size();
    for (std::size_t r = 0; r < n; ++r)
      for (const auto& place :
           fill<2>(water ? scene_.fluid.regions[r] : scene_.soils[r].shape, dx, offset, 0.0, 1).position)
        for (const auto& piece : pieces_of(scene_.walls[w].face)) {
          const Point3 x(place.x(), place.y(), 0.0);
          const double distance = distance_from(piece, x);
          if (distance < 0.25 * dx)
            fail(fmt::format("{}[{}]", water ? "fluid.region" : "soil", r),
                 fmt::format(
                     "has a particle at {} m, {:.2g} spacings from {}, which runs through it; expected rows half "
                     "a spacing from the line: draw one {} on either side, up to the line",
                     shown(x), distance / dx, named("wall", w, scene_.walls[w].name), water ? "region" : "soil"));
        }
  }

  [[nodiscard]] double conductivity(const Soil& soil) const {
    return porous::seepage_at(scene_, soil, soil.porosity).conductivity;
  }
  /// Number of rows that a layer of conductivity k needs beside another, since kernels smear its resistance over the
  /// neighbouring rows. Largest errors of the flow, at any angle to the lattice:
  /// through a slow layer at a contrast of 10, 2 % with two rows and 5 % with 1.6;
  /// through a slow layer at contrasts from 100 on, 2 % with three rows, 14 % with two, a factor of five with one, the
  /// wrong sign with half a row; through a fast layer at any contrast, 2 % with 1.6 rows.
  [[nodiscard]] static double rows_needed(double k, double other) {
    const double contrast = std::max(k / other, other / k);
    if (contrast <= 2.0) return 0.0;
    if (k > other) return 1.5;
    return contrast <= 10.0 ? 2.0 : 3.0;
  }
  [[noreturn]] void too_thin(std::size_t i, double thin, std::size_t beside, double rows) const {
    const double dx = scene_.fluid.particle_spacing;
    fail(
        fmt::format("soil[{}]", i),
        fmt::format("is {:.4g} m thin, {:.2g} rows of particles, with a conductivity of {:.3g} m/s beside {} of {:.3g} "
                    "m/s; expected {:g} rows or more: give a fluid.particle_spacing of {:.3g} m or less, or a "
                    "thicker layer with as much more conductivity",
                    thin, thin / dx, conductivity(scene_.soils[i]), named("soil", beside, scene_.soils[beside].name),
                    conductivity(scene_.soils[beside]), rows, thin / rows));
  }

  void layers_of_few_rows() const {
    for (std::size_t i = 0; i < scene_.soils.size(); ++i) {
      if (d_ == 2 && scene_.soils[i].shape.kind != Shape::Kind::ball)
        thin_places(i);
      else
        thin_as_a_whole(i);
    }
  }

  /// For boxes in 3D, and discs or balls: their smallest extent is compared with the rows needed.
  void thin_as_a_whole(std::size_t i) const {
    const double dx = scene_.fluid.particle_spacing;
    const auto [lower, upper] = bounds(scene_.soils[i].shape);
    const double thin = (upper - lower).head(d_).minCoeff();
    for (std::size_t j = 0; j < scene_.soils.size(); ++j) {
      const auto [low, high] = bounds(scene_.soils[j].shape);
      const Eigen::Array3d gap = (low - upper).cwiseMax(lower - high).array();
      if (i == j || (gap.head(d_) > 0.5 * dx).any()) continue;
      const double rows = rows_needed(conductivity(scene_.soils[i]), conductivity(scene_.soils[j]));
      if (thin < 0.999 * rows * dx) too_thin(i, thin, j, rows);
    }
  }

  /// For boxes and polygons in 2D: the thickness is measured inwards from every edge that touches another soil, through
  /// all soil of the same conductivity. The tip of a wedge is always thin for a few rows: the layer is refused only if
  /// it is thin along more than twice the needed rows, or along half of the edges that touch.
  void thin_places(std::size_t i) const {
    const double dx = scene_.fluid.particle_spacing, k = conductivity(scene_.soils[i]);
    const auto same = [&](const Soil* soil) { return soil && rows_needed(k, conductivity(*soil)) == 0.0; };
    const std::vector<Point3> corners = corners_of(scene_.soils[i].shape, 2);
    double around = 0.0, area = 0.0;
    for (std::size_t c = 0; c < corners.size(); ++c) {
      const Point3 a = corners[c] - corners[0], b = corners[(c + 1) % corners.size()] - corners[0];
      area += 0.5 * (a.x() * b.y() - a.y() * b.x());
    }
    struct Thin {
      double length = 0.0, least = HUGE_VAL, rows = 0.0;
    };
    std::map<std::size_t, Thin> found;
    for (std::size_t c = 0; c < corners.size(); ++c) {
      const Piece edge{corners[c], corners[(c + 1) % corners.size()]};
      const Point3 inward = area > 0.0 ? edge.left() : Point3(-edge.left());
      const auto places = places_along(edge, 0.5 * dx);
      for (const auto& x : places) {
        const Soil* beside = nullptr;
        for (const double gap : {0.05, 0.25, 0.5})
          if (!beside) beside = soil_at(scene_, x - gap * dx * inward);
        if (!beside || same(beside)) continue;
        const double part = edge.length() / static_cast<double>(places.size());
        around += part;
        const double rows = rows_needed(k, conductivity(*beside)), step = 0.025 * dx;
        double deep = step;
        while (deep < 0.999 * rows * dx && same(soil_at(scene_, x + deep * inward))) deep += step;
        if (deep >= 0.999 * rows * dx) continue;
        auto& thin = found[static_cast<std::size_t>(beside - scene_.soils.data())];
        thin.length += part;
        thin.least = std::min(thin.least, deep);
        thin.rows = rows;
      }
    }
    for (const auto& [beside, thin] : found)
      if (thin.length > std::min(2.0 * thin.rows * dx, 0.5 * around)) too_thin(i, thin.least, beside, thin.rows);
  }

  /// Refuses soil of very low porosity beside free water, meant as a wall: free water that runs against it gains energy
  /// (a factor of seven at a porosity of 0.02, a tenth at 0.1).
  void solid_bodies() const {
    constexpr double least = 0.1;
    for (std::size_t i = 0; i < scene_.soils.size(); ++i) {
      if (scene_.soils[i].porosity >= least) continue;
      for (const auto& region : scene_.fluid.regions)
        for (const auto& x : places_in(region, scene_.fluid.particle_spacing, d_))
          if (soil_at(scene_, x) == nullptr)
            fail(fmt::format("soil[{}].porosity", i),
                 fmt::format(
                     "expected {} or more beside free water, found {}: so dense a soil is a solid body, which is "
                     "drawn as a {}",
                     least, scene_.soils[i].porosity,
                     d_ == 3 ? "[[wall]] with a 'shape' and domain = \"outside\"" : "closed [[wall]]"));
    }
  }

  /// Refuses openings below the water's surface, since the flow through them is wrong. Nothing passes an `outlet`. A
  /// face with a `pressure` passes a hundredth of the right flow, and one with a `head` more than an opening can pass.
  /// A face with a negative `discharge` loses particles.
  void openings_under_water() const {
    if (up_.isZero() || d_ != 2) return;
    const double dx = scene_.fluid.particle_spacing;
    double level = -HUGE_VAL;
    for (const auto& region : scene_.fluid.regions) level = std::max(level, extent(region, up_, d_).second);
    for (std::size_t i = 0; i < scene_.water_faces.size(); ++i) {
      const WaterFace& f = scene_.water_faces[i];
      const auto draws = [](const std::optional<Series>& series, double below) {
        return series && std::any_of(series->knots.begin(), series->knots.end(),
                                     [&](const auto& knot) { return knot.second < below; });
      };
      const std::string key = f.outlet                          ? "outlet"
                              : f.pressure                      ? "pressure"
                              : draws(f.head, level - 0.5 * dx) ? "head"
                              : draws(f.discharge, 0.0)         ? "discharge"
                                                                : "";
      if (f.face.points.size() != 2 || key.empty()) continue;
      const Point3 &a = f.face.points.front(), &b = f.face.points.back();
      const Point3 along = (b - a).normalized(), inwards(-along.y(), along.x(), 0.0);
      const Point3 before = 0.5 * (a + b) + 0.25 * dx * inwards;
      const Point3 above = (up_.dot(a) > up_.dot(b) ? a : b) + 0.25 * dx * inwards + dx * up_;
      const auto free = [&](const Point3& x) { return in_fluid_region(scene_, x) && !soil_at(scene_, x); };
      if (!free(before) || !free(above)) continue;
      fail(fmt::format("water_face[{}].{}", i, key),
           fmt::format("the opening from {} to {} m lies under water, and what a submerged opening passes by '{}' is "
                       "wrong: not the flow of its head; expected an opening that reaches the water's surface{}, or a "
                       "gap between the walls with a floor behind it that ends at an outlet in the air",
                       shown(a), shown(b), key, f.discharge ? ", a discharge that comes in" : ""));
    }
  }

  /// Refuses a face of zero pressure in front of dry soil. Air is behind such a face, so that no water should enter;
  /// but a face with `pressure` or `head` lets water into dry soil (error of the discharge of a filter under a dam's
  /// toe: 47 %). The case must give `outlet` instead.
  void drains_without_pressure() const {
    if (up_.isZero() || scene_.deformable() || d_ != 2) return;
    const double dx = scene_.fluid.particle_spacing;
    for (std::size_t i = 0; i < scene_.water_faces.size(); ++i) {
      const WaterFace& f = scene_.water_faces[i];
      const auto& given = f.pressure ? f.pressure : f.head;
      if (!given) continue;
      double highest = -HUGE_VAL;
      for (const auto& [time, value] : given->knots) highest = std::max(highest, value);
      for (const auto& piece : pieces_of(f.face)) {
        const double level = up_.dot(0.5 * (piece.a + piece.b));
        const bool no_pressure = f.pressure ? highest <= 0.0 : std::abs(highest - level) < 0.1 * dx;
        const Point3 before = 0.5 * (piece.a + piece.b) + 0.25 * dx * piece.left();
        const Soil* soil = soil_at(scene_, before);
        // Not refused where water can fall in from above, or where suction draws water in.
        if (!no_pressure || up_.dot(piece.left()) < -0.01 || !soil || soil->suction_head > 0.0 ||
            in_fluid_region(scene_, before))
          continue;
        fail(fmt::format("water_face[{}].{}", i, f.pressure ? "pressure" : "head"),
             fmt::format("the pressure is zero along the face from {} to {} m, before which the soil is dry: air is "
                         "behind it, and water only leaves there; expected outlet = true",
                         shown(piece.a), shown(piece.b)));
      }
    }
  }

  /// A face given by point and normal has no upper end: its head must not exceed the top of the soil in front of it.
  void heads_below_the_soils_top() const {
    if (up_.isZero()) return;
    const double dx = scene_.fluid.particle_spacing;
    for (std::size_t i = 0; i < scene_.water_faces.size(); ++i) {
      const WaterFace& f = scene_.water_faces[i];
      if (!f.face.points.empty() || !f.head) continue;
      const Point3 normal = f.face.normal.normalized();
      if (std::abs(normal.dot(up_)) > 0.99) continue;  // the face is horizontal; water stands over it
      double top = -HUGE_VAL;
      for (const auto& soil : scene_.soils)
        for (const auto& x : places_in(soil.shape, dx, d_))
          if (const double before = normal.dot(x - f.face.point); before > 0.0 && before < 1.5 * dx)
            top = std::max(top, up_.dot(x) + 0.5 * dx);
      double highest = -HUGE_VAL;
      for (const auto& [time, value] : f.head->knots) highest = std::max(highest, value);
      if (!(top > -HUGE_VAL) || highest <= top + 0.5 * dx) continue;
      const bool lid = std::any_of(scene_.walls.begin(), scene_.walls.end(), [&](const Wall& wall) {
        return wall.water != Wall::ForWater::none && wall.face.points.empty() &&
               up_.dot(wall.face.normal.normalized()) < -0.99 && std::abs(up_.dot(wall.face.point) - top) < dx;
      });
      if (!lid)
        fail(fmt::format("water_face[{}].head", i),
             fmt::format(
                 "the water behind the face rises to {:.6g} m, above the soil's upper end at {:.4g} m, and "
                 "cannot run over there: a face by 'point' and 'normal' has no crest; expected a lower head, soil "
                 "up to it, or a [[wall]] on the soil's top",
                 highest, top));
    }
  }

  /// Refuses a part of a plane that is not a rectangle along the axes, or along which soil is missing somewhere: the
  /// force of the load is its traction times the area of that part.
  void part_of_plane(const Face& f, const std::string& key) const {
    const double dx = scene_.solid.particle_spacing;
    if (d_ != 3) fail(key, "belongs to dimension = 3; expected 'points', a line");
    constexpr double along_axis = 1.0 - 1e-9;
    const Point3 normal = f.normal.isZero() ? f.normal : f.normal.normalized();
    if (!plain_box(*f.within) || normal.cwiseAbs().maxCoeff() < along_axis)
      fail(key,
           "expected a box along the axes, without turn, scale, move and cuts, on a plane with 'point' and a 'normal' "
           "along an axis");
    const LoadedPart part = loaded_part(scene_, f);
    const double level = f.point[part.across];
    if (!(part.area() > 0.0) || level < f.within->min[part.across] || level > f.within->max[part.across])
      fail(key, "has no part of the load's plane with soil in it; expected a box that contains a part of it");
    std::array<int, 2> count{};
    for (int k = 0; k < 2; ++k)
      count[static_cast<std::size_t>(k)] = std::max(
          1, static_cast<int>(std::ceil((part.high - part.low)[part.axes[static_cast<std::size_t>(k)]] / (0.5 * dx))));
    for (int p = 0; p < count[0]; ++p)
      for (int q = 0; q < count[1]; ++q) {
        Point3 x = part.low;
        x[part.axes[0]] += (p + 0.5) / count[0] * (part.high - part.low)[part.axes[0]];
        x[part.axes[1]] += (q + 0.5) / count[1] * (part.high - part.low)[part.axes[1]];
        if (soil_at(scene_, x + 0.5 * dx * normal) == nullptr || soil_at(scene_, x - 0.5 * dx * normal) != nullptr)
          fail(key, fmt::format("the soil's surface does not lie along the load's plane at {} m; expected a box over "
                                "soil all along the plane",
                                shown(x)));
      }
  }

  /// Refuses a load without a plane that is no pressure, or whose shape does not contain all soil: the force of a
  /// pressure is that of a uniform stress, and at the end of a part it would pull at the soil's inside. Water particles
  /// would have to bear their part of it along a face.
  void pressure_on_all_sides(const Load& load, const std::string& key) const {
    const double dx = scene_.solid.particle_spacing;
    if (d_ != 3) fail(key + ".within", "belongs to dimension = 3; expected 'points', a line");
    if (!load.pressure)
      fail(key, "without 'point' and 'normal' expected a 'pressure', which acts on the whole surface of the soil");
    if (scene_.coupled() && !scene_.is_field())
      fail(key,
           "a pressure on all sides of soil with water particles is not computed; expected "
           "fluid.representation = \"field\"");
    if (!scene_.plates.empty()) fail(key, "a pressure on all sides would act under the plates, too; expected none");
    for (const auto& soil : scene_.soils)
      for (const auto& x : places_in(soil.shape, dx, d_))
        if (!contains(*load.face.within, x, d_))
          fail(key + ".within",
               fmt::format("does not contain the soil at {} m: a pressure without 'point' and 'normal' acts on the "
                           "whole surface of the soil; expected a shape around all soil",
                           shown(x)));
  }

  /// Refuses loads far from the soil's surface, that is, from the last particles against the load's normal. The force
  /// has an error of 0.3 % within 2 spacings of the surface, and is 1.5 to 2.7 times too large 4 spacings from it.
  void loads() const {
    const double dx = scene_.solid.particle_spacing;
    constexpr double lengths_per_spacing = 1.2;  // smoothing length over spacing
    const double reach = 2.0 * sph::support_radius * lengths_per_spacing * dx;
    constexpr double farthest = 2.0;  // spacings
    for (std::size_t i = 0; i < scene_.loads.size(); ++i) {
      const Face& f = scene_.loads[i].face;
      struct Plane {
        Point3 point, normal, along;
        double from, to;
      };
      std::vector<Plane> planes;
      if (f.points.empty()) planes.push_back({f.point, f.normal.normalized(), Point3::Zero(), -HUGE_VAL, HUGE_VAL});
      for (const auto& piece : pieces_of(f)) {
        const Point3 along = (piece.b - piece.a).normalized();
        planes.push_back({piece.a, piece.left(), along, along.dot(piece.a), along.dot(piece.b)});
      }
      if (scene_.loads[i].on_all_sides()) {
        pressure_on_all_sides(scene_.loads[i], fmt::format("load[{}]", i));
        continue;
      }
      if (f.within) part_of_plane(f, fmt::format("load[{}].within", i));
      bool any = std::ranges::any_of(scene_.soils, [&](const Soil& soil) {  // sampled too coarsely to decide
        return spacing_to_look_at(soil.shape, dx, d_) > reach;
      });
      for (const auto& soil : scene_.soils)
        for (const auto& x : places_in(soil.shape, dx, d_))
          for (const auto& plane : planes) {
            const double inside = plane.normal.dot(x - plane.point), along = plane.along.dot(x);
            if (std::abs(inside) > reach || along < plane.from || along > plane.to) continue;
            if (f.within && !loaded_part(scene_, f).covers(x)) continue;
            any = true;
            const double off = std::abs(inside - 0.5 * dx);
            if (off <= (farthest + 0.25) * dx || soil_at(scene_, x - dx * plane.normal) != nullptr) continue;
            fail(fmt::format("load[{}]", i),
                 fmt::format(
                     "the soil's surface at {} m lies {:.3g} m off the load's face, within its reach; expected "
                     "surfaces within {:.3g} m of the face ({:g} spacings) or beyond {:.3g} m: move the face to "
                     "the surface{}",
                     shown(x), off, farthest * dx, farthest, reach,
                     f.points.empty() ? ", or, as a plane goes on without end, leave out what else it meets" : ""));
          }
      if (!any)
        fail(fmt::format("load[{}]", i),
             fmt::format("no soil lies within {:.3g} m of the load's face: expected the face on the soil's surface",
                         reach));
    }
  }

  /// Whether a wall for soil stands within a spacing of x.
  [[nodiscard]] bool beside_wall(const Point3& x) const {
    const double reach = 1.01 * scene_.solid.particle_spacing;
    return std::any_of(scene_.walls.begin(), scene_.walls.end(), [&](const Wall& wall) {
      if (wall.soil == Wall::ForSoil::none) return false;
      if (wall.face.points.empty()) return std::abs(wall.face.normal.normalized().dot(x - wall.face.point)) < reach;
      const auto pieces = pieces_of(wall.face);
      return std::any_of(pieces.begin(), pieces.end(), [&](const Piece& p) { return distance_from(p, x) < reach; });
    });
  }

  /// Height of the highest cut or slope of the soil's surface [m], including the sides that no wall supports.
  [[nodiscard]] double relief() const {
    const double dx = scene_.solid.particle_spacing;
    struct Column {
      Point3 top, bottom;
    };
    std::map<std::array<long, 3>, Column> columns;
    for (const auto& soil : scene_.soils)
      for (const auto& x : places_in(soil.shape, dx, d_)) {
        const Point3 across = x - up_.dot(x) * up_;
        std::array<long, 3> place{};
        for (std::size_t d = 0; d < 3; ++d)
          place[d] = std::lround(std::floor(across[static_cast<Eigen::Index>(d)] / dx + 1e-6));
        auto& column = columns.try_emplace(place, Column{x, x}).first->second;
        if (up_.dot(x) > up_.dot(column.top)) column.top = x;
        if (up_.dot(x) < up_.dot(column.bottom)) column.bottom = x;
      }
    double highest = -HUGE_VAL, lowest = HUGE_VAL;
    for (const auto& [place, column] : columns) {
      highest = std::max(highest, up_.dot(column.top));
      lowest = std::min(lowest, up_.dot(column.top));
      for (std::size_t d = 0; d < static_cast<std::size_t>(d_); ++d)
        for (const long step : {-1L, 1L}) {
          auto next = place;
          next[d] += step;
          const bool level = std::abs(up_[static_cast<Eigen::Index>(d)]) < 0.5;
          const auto& periodic = scene_.general.periodic;
          const bool goes_on = std::find(periodic.begin(), periodic.end(), static_cast<int>(d)) != periodic.end();
          if (level && !goes_on && !columns.contains(next) && !beside_wall(column.top))
            lowest = std::min(lowest, up_.dot(column.bottom));
        }
    }
    return highest > lowest ? highest - lowest : 0.0;
  }

  /// Refuses soil that has no friction and no tensile strength and is higher than its cohesion can support. Without
  /// friction the cone has no apex, so that soil would carry any tension and fly apart where it slides (a vertical cut:
  /// 200 m/s after 0.4 s). Not refused where cohesion c supports the soil of unit weight gamma (a vertical cut of up to
  /// 3.83 c / gamma), nor where cohesion is negligible beside the weight.
  void tension() const {
    if (up_.isZero()) return;
    std::optional<double> height;
    for (std::size_t i = 0; i < scene_.soils.size(); ++i) {
      const Soil& soil = scene_.soils[i];
      if (soil.friction_angle > 0.0 || soil.tensile_strength || !material(scene_.model_of(soil)).has_cone()) continue;
      if (!height) height = relief();
      const double gamma = (1.0 - soil.porosity) * soil.grain_density * scene_.general.gravity.norm();
      const double stands = 3.83 * soil.cohesion / gamma;
      if (stands >= *height || soil.cohesion <= 0.01 * gamma * *height) continue;
      fail(
          fmt::format("soil[{}].tensile_strength", i),
          fmt::format("the soil stands {:.3g} m high, more than the {:.3g} m that its cohesion bears, and with "
                      "friction_angle = 0 the cone has no apex to limit the tension: expected the largest mean tension "
                      "(0, or up to the cohesion of {:g} Pa), found none",
                      *height, stands, soil.cohesion));
    }
  }

  /// Refuses a wall for water under a load: the load moves the soil, but the wall and the water at it would stay where
  /// they are.
  void loaded_plates() const {
    const double dx = scene_.fluid.particle_spacing;
    const auto overlap = [&](const Face& f, const Face& g) {
      if (f.points.empty() && g.points.empty()) {
        const Point3 n = f.normal.normalized();
        return n.cross(g.normal.normalized()).norm() < 1e-6 && std::abs(n.dot(g.point - f.point)) < 0.1 * dx;
      }
      for (const auto& p : pieces_of(f))
        for (const auto& q : pieces_of(g)) {
          if (p.left().dot(q.left()) < 0.999) continue;
          const Point3 along = (p.b - p.a).normalized();
          const double from = std::max(0.0, along.dot(q.a - p.a)), to = std::min(p.length(), along.dot(q.b - p.a));
          if (std::abs(p.left().dot(q.a - p.a)) < 0.1 * dx && to - from > dx) return true;
        }
      return false;
    };
    for (std::size_t i = 0; i < scene_.walls.size(); ++i)
      for (std::size_t j = 0; j < scene_.loads.size(); ++j)
        if (scene_.walls[i].water != Wall::ForWater::none && overlap(scene_.walls[i].face, scene_.loads[j].face))
          fail(fmt::format("wall[{}]", i),
               fmt::format("a wall stands still, but {} moves the soil there, and the water would cling to the wall: "
                           "expected a drained surface under the load (a [[water_face]] with pressure = 0), the load "
                           "elsewhere, or a tight [[plate]] with fluid.representation = \"field\"",
                           named("load", j, scene_.loads[j].name)));
  }

  int d_;
  Point3 up_ = Point3::Zero();
};

}  // namespace

void check_supported(const Case& scene, const Places& places) { Supported(scene, places).all(); }
void check_loads(const Case& scene, const Places& places) { Supported(scene, places).loads_on_soil(); }

}  // namespace poretwin
