// Small scenes that several tests share: a soil column on a base between side walls, and inboxes as a fluid would fill
// them.
#pragma once

#include "common/case/case.hpp"
#include "common/coupling/exchange.hpp"
#include "solid_solver/phase.hpp"

#include <functional>

namespace poretwin::solid::test {

struct ColumnSpec {
  int dimension = 2;
  double width = 0.4, height = 1.0, spacing = 0.05;
  double gravity = 9.81;
  Wall::ForSoil base = Wall::ForSoil::fixed;
  bool sides = true;  ///< rollers
};

inline Face plane(const Point3& point, const Point3& normal) {
  Face face;
  face.point = point;
  face.normal = normal;
  return face;
}

inline Case column(const ColumnSpec& spec) {
  Case scene;
  const int up = spec.dimension - 1;
  scene.general.dimension = spec.dimension;
  scene.general.gravity = Point3::Zero();
  scene.general.gravity[up] = -spec.gravity;
  Soil soil;
  soil.name = "sand";
  for (int d = 0; d < up; ++d) soil.shape.max[d] = spec.width;
  soil.shape.max[up] = spec.height;
  soil.youngs_modulus = 3e6;
  soil.poissons_ratio = 0.3;
  soil.porosity = 0.4;
  soil.grain_density = 2600.0;
  scene.soils = {soil};
  scene.solid.particle_spacing = spec.spacing;
  Wall base;
  base.name = "base";
  base.face = plane(Point3::Zero(), Point3::Unit(up));
  base.soil = spec.base;
  if (spec.base != Wall::ForSoil::none) scene.walls.push_back(base);
  for (int d = 0; spec.sides && d < up; ++d)
    for (const double side : {0.0, 1.0}) {
      Wall wall;
      wall.name = "side";
      wall.face = plane(spec.width * side * Point3::Unit(d), (side > 0.0 ? -1.0 : 1.0) * Point3::Unit(d));
      wall.soil = Wall::ForSoil::roller;
      scene.walls.push_back(wall);
    }
  return scene;
}

/// A load on the column's top [Pa], from `start` on.
inline Load top_load(const ColumnSpec& spec, double pressure, std::optional<double> start = std::nullopt) {
  const int up = spec.dimension - 1;
  Load load;
  load.name = "top";
  load.face = plane(spec.height * Point3::Unit(up), -Point3::Unit(up));
  load.traction = -pressure * Point3::Unit(up);
  load.start = start;
  return load;
}

/// The inbox that a fluid would send: zero impulse and prediction, pressure as a function of position.
template <int D>
coupling::Inbox wet_inbox(const Solid<D>& solid, const std::function<double(const Vec<D>&)>& pressure,
                          double coverage = 1.0) {
  const auto& x = solid.state().particles.position;
  const std::size_t n = x.size();
  coupling::Inbox inbox;
  inbox.coverage.assign(n, coverage);
  inbox.asymmetry.assign(n, 0.0);
  coupling::Field p{std::string(coupling::field::pore_pressure), 1, {}};
  for (const auto& at : x) p.values.push_back(pressure(at));
  inbox.fields = {p,
                  {std::string(coupling::field::predicted_solid_velocity), D, std::vector<double>(n * D, 0.0)},
                  {std::string(coupling::field::predicted_change), D, std::vector<double>(n * D, 0.0)},
                  {std::string(coupling::field::drag_impulse), D, std::vector<double>(n * D, 0.0)},
                  {std::string(coupling::field::soil_fraction), 1, std::vector<double>(n, 1.0)},
                  {std::string(coupling::field::surface_gradient), D, std::vector<double>(n * D, 0.0)},
                  {std::string(coupling::field::surface_share), 1, std::vector<double>(n, 0.0)},
                  {std::string(coupling::field::spreading_rate), 1, std::vector<double>(n, 0.0)}};
  return inbox;
}

/// The values of a field in an inbox, to be set.
inline std::vector<double>& values(coupling::Inbox& inbox, std::string_view name) {
  for (auto& f : inbox.fields)
    if (f.name == name) return f.values;
  throw std::runtime_error("no such field");
}

inline const coupling::Field& field_of(const coupling::Publication& publication, std::string_view name) {
  for (const auto& f : publication.fields)
    if (f.name == name) return f;
  throw std::runtime_error("no such field");
}

/// A gauge of the solid that is called as its kind.
inline Gauge whole(const std::string& kind) {
  Gauge gauge;
  gauge.name = gauge.kind = kind;
  gauge.phase = "solid";
  return gauge;
}

/// A point gauge of the solid.
template <int D>
Gauge point_gauge(const std::string& name, const std::string& quantity, std::vector<Point3> points) {
  Gauge gauge = whole("point");
  gauge.name = name;
  gauge.quantity = quantity;
  gauge.points = std::move(points);
  return gauge;
}

/// Runs windows of length `interval` without water until `end`.
template <int D>
void run_dry(Solid<D>& solid, double end, double interval) {
  for (std::uint64_t k = 0; solid.state().time < end - 1e-9; ++k) solid.advance({k, solid.state().time, interval}, {});
}

}  // namespace poretwin::solid::test
