#include "common/case/bodies.hpp"

#include "common/case/amounts.hpp"
#include "common/case/complaints.hpp"
#include "common/case/document.hpp"
#include "common/geometry/crossing.hpp"
#include "common/geometry/solid.hpp"

#include <cmath>

namespace poretwin {
namespace {

class Bodies : Complaints {
 public:
  Bodies(Case& scene, const Places& places)
      : Complaints(scene, places), d_(scene.general.dimension), spacing_(finest_spacing(scene)) {}

  /// Makes the solid of a shape. always: even for a box or ball along the axes. facets: factor on the largest distance
  /// allowed between facets and the curved surface for which they stand.
  void make(Shape& shape, const std::string& key, bool always = false, double facets = 1.0) const {
    if (d_ == 2) return place_in_plane(shape, key);
    const bool turned = shape.placement && shape.placement->turn != 0.0;
    const bool plain = shape.kind == Shape::Kind::ball || (shape.kind == Shape::Kind::box && !turned);
    if (plain && !always && shape.within.empty() && shape.without.empty()) return place_as_it_is(shape);
    std::vector<Solid::Part> parts;
    parts.push_back({mesh_of(shape, key, facets), false});
    for (std::size_t i = 0; i < shape.within.size(); ++i)
      parts.push_back({mesh_of(shape.within[i], fmt::format("{}.within[{}]", key, i), facets), false});
    for (std::size_t i = 0; i < shape.without.size(); ++i)
      parts.push_back({mesh_of(shape.without[i], fmt::format("{}.without[{}]", key, i), facets), true});
    // With cells as large as a spacing, the volume of a small body would be wrong by 0.4 %.
    constexpr double resolution = 0.1;  // spacings
    shape.solid = std::make_shared<const Solid>(std::move(parts), resolution * spacing_);
    if (!(shape.solid->volume() > 0.0))
      fail(key, "nothing is left of the shape: expected 'within' that meet it, and 'without' that leave some of it");
  }

 private:
  void place_in_plane(Shape& s, const std::string& key) const {
    if (s.kind != Shape::Kind::box && s.kind != Shape::Kind::ball && s.kind != Shape::Kind::polygon)
      fail(key + ".shape", "expected \"box\", \"ball\" or \"polygon\" with dimension = 2");
    for (const char* of_space : {".along", ".around"})
      if (given(key + of_space)) fail(key + of_space, "belongs to dimension = 3, found dimension = 2");
    for (const auto& [of_space, parts] : {std::pair{".within", &s.within}, {".without", &s.without}})
      if (!parts->empty()) fail(key + of_space, "belongs to dimension = 3, found dimension = 2");
    if (s.placement && s.kind == Shape::Kind::box && s.placement->turn != 0.0)
      fail(key + ".turn", "a box in 2D lies along the axes; expected shape = \"polygon\" for one that is turned");
    place_as_it_is(s);
  }

  /// Places boxes along the axes, balls, and polygons in the plane.
  void place_as_it_is(Shape& s) const {
    if (!s.placement) return;
    const Placement p = *s.placement;
    if (s.kind == Shape::Kind::box)
      for (auto* x : {&s.min, &s.max}) *x = placed(p, *x, d_);
    for (auto& x : s.points) x = placed(p, x, d_);
    s.centre = placed(p, s.centre, d_);
    s.radius *= p.scale;
    s.placement.reset();
  }

  void measures(const Shape& s, const std::string& key) const {
    const auto differ = [&](const Point3& a, const Point3& b) { return (b - a).norm() > 1e-9 * spacing_; };
    switch (s.kind) {
      case Shape::Kind::box:
        if (!((s.max - s.min).minCoeff() > 0.0))
          fail(key + ".max",
               fmt::format("expected every coordinate above that of 'min' {}, found {}", shown(s.min), shown(s.max)));
        break;
      case Shape::Kind::ball:
        if (!(s.radius > 0.0)) fail(key + ".radius", "expected a radius > 0 m, found 0");
        break;
      case Shape::Kind::cylinder:
      case Shape::Kind::cone:
        if (s.ends.size() != 2 || !differ(s.ends[0], s.ends[1]))
          fail(key + ".ends",
               fmt::format("expected the two ends of the axis, found {}",
                           s.ends.size() == 2 ? "one point twice" : fmt::format("{} points", s.ends.size())));
        if (!(std::max(s.radius, s.kind == Shape::Kind::cone ? s.end_radius : 0.0) > 0.0))
          fail(key + ".radius", "expected a radius > 0 m, found 0");
        break;
      case Shape::Kind::polygon:
        section(s, key);
        break;
      case Shape::Kind::mesh:
      case Shape::Kind::terrain:
        break;
    }
    if (s.placement && !(s.placement->axis.norm() > 0.0))
      fail(key + ".axis", "expected a direction, found a vector of length zero");
  }

  void section(const Shape& s, const std::string& key) const {
    if (s.along.size() + s.around.size() != 1)
      fail(key + ".points",
           "a polygon in 3D is extruded along or revolved around one axis: expected along = [\"y\"] with 'from' "
           "and 'to', or around = [\"z\"]");
    if (!s.along.empty() && !(s.to > s.from))
      fail(key + ".to", fmt::format("expected more than 'from', {} m, found {} m", s.from, s.to));
    if (s.points.size() < 3)
      fail(key + ".points", fmt::format("expected 3 corners or more, found {}", s.points.size()));
    if (const auto found = self_crossing(s.points, true))
      fail(key + ".points",
           fmt::format("edges {} and {} cross at [{:.6g}, {:.6g}] m; expected a line that does not cross itself",
                       found->first + 1, found->second + 1, found->at.x(), found->at.y()));
    for (const auto& x : s.points)
      if (!s.around.empty() && x.x() < 0.0)
        fail(key + ".points", fmt::format("expected distances from the axis, 0 m or more, found {} m", x.x()));
  }

  [[nodiscard]] TriangleMesh mesh_of(const Shape& s, const std::string& key, double facets) const {
    measures(s, key);
    const bool from_file = s.kind == Shape::Kind::mesh || s.kind == Shape::Kind::terrain;
    const std::string at = from_file ? key + ".file" : key;
    const auto explained = [&](const std::string& what) {
      return from_file ? fmt::format("'{}': {}", s.file, what) : what;
    };
    if (!(spacing_ > 0.0))
      fail(key, "expected a particle spacing (fluid.particle_spacing or solid.particle_spacing) > 0 m");
    Triangles surface;
    try {
      surface = surface_of(s, facets * spacing_,
                           [&](const std::string& file) { return read_text(scene_.path.parent_path() / file); });
    } catch (const CaseError& error) {
      fail(at, explained(error.what()));
    } catch (const FileError& error) {
      fail(at, explained(error.what()));
    }
    TriangleMesh mesh(std::move(surface));
    const auto [lower, upper] = mesh.bounds();
    const double size = (upper - lower).maxCoeff() / spacing_;
    constexpr double most = 1e4, least = 1e-4;
    if (from_file && (size > most || size < least))
      fail(at, explained(fmt::format(
                   "measures {:.4g} x {:.4g} x {:.4g} m, {:.3g} particle spacings: expected {:g} at most; is it drawn "
                   "in other units? 'scale' makes it larger or smaller (0.001 for millimetres)",
                   (upper - lower).x(), (upper - lower).y(), (upper - lower).z(), size, size > most ? most : least)));
    if (const auto fault = fault_of(mesh))
      fail(at, explained(fmt::format("{}, at {} m; expected a closed surface that does not cross itself", fault->what,
                                     shown(fault->at))));
    return mesh;
  }

  int d_;
  double spacing_;
};

}  // namespace

void make_solids(Case& scene, const Places& places) {
  const Bodies bodies(scene, places);
  for (std::size_t i = 0; i < scene.soils.size(); ++i) bodies.make(scene.soils[i].shape, fmt::format("soil[{}]", i));
  for (std::size_t i = 0; i < scene.fluid.regions.size(); ++i)
    bodies.make(scene.fluid.regions[i], fmt::format("fluid.region[{}]", i));
  for (std::size_t i = 0; i < scene.walls.size(); ++i)
    if (scene.walls[i].shape) {
      // Soil that slides along a wall is strained at every edge between facets: finer facets strain it less.
      constexpr double finer = 0.1;
      const bool beside_soil = scene.deformable() && scene.walls[i].soil != Wall::ForSoil::none;
      bodies.make(*scene.walls[i].shape, fmt::format("wall[{}]", i), true, beside_soil ? finer : 1.0);
    }
  for (std::size_t i = 0; i < scene.pore_pressures.size(); ++i)
    if (scene.pore_pressures[i].region)
      bodies.make(*scene.pore_pressures[i].region, fmt::format("pore_pressure[{}].region", i));
  for (std::size_t i = 0; i < scene.water_faces.size(); ++i)
    if (auto& within = scene.water_faces[i].face.within) bodies.make(*within, fmt::format("water_face[{}].within", i));
  for (std::size_t i = 0; i < scene.rains.size(); ++i)
    if (auto& within = scene.rains[i].face.within) bodies.make(*within, fmt::format("rain[{}].within", i));
  for (std::size_t i = 0; i < scene.gauges.size(); ++i)
    if (scene.gauges[i].region) bodies.make(*scene.gauges[i].region, fmt::format("gauge[{}].region", i));
}

}  // namespace poretwin
