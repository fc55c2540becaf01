// Small cases in memory, and a driver for the fluid alone.
#pragma once

#include "common/case/case.hpp"
#include "common/coupling/phase.hpp"

namespace poretwin::fluid::test {

inline Shape box(double x0, double y0, double x1, double y1) {
  Shape shape;
  shape.min = Point3(x0, y0, 0.0);
  shape.max = Point3(x1, y1, 0.0);
  return shape;
}

/// A line between two points; the domain is on its left.
inline Face line(double x0, double y0, double x1, double y1) {
  Face face;
  face.points = {Point3(x0, y0, 0.0), Point3(x1, y1, 0.0)};
  return face;
}

inline Wall wall(Face face) {
  Wall w;
  w.face = std::move(face);
  return w;
}

/// A wall along a line of several pieces; the domain is on its left.
inline Wall line_of(const std::vector<std::array<double, 2>>& points) {
  Face face;
  for (const auto& [x, y] : points) face.points.push_back(Point3(x, y, 0.0));
  return wall(face);
}

inline Series constant(double value) { return Series{{{0.0, value}}}; }

inline WaterFace head_face(Face face, double head) {
  WaterFace w;
  w.face = std::move(face);
  w.head = constant(head);
  return w;
}

inline WaterFace pressure_face(Face face, double pressure) {
  WaterFace w;
  w.face = std::move(face);
  w.pressure = constant(pressure);
  return w;
}

inline Soil sand() {
  Soil soil;
  soil.porosity = 0.4;
  soil.hydraulic_conductivity = 1.1e-4;
  return soil;
}

/// A gauge of the fluid.
inline Gauge gauge(const std::string& name, const std::string& kind, const std::vector<Point3>& points = {},
                   const std::string& quantity = {}) {
  Gauge result;
  result.name = name;
  result.phase = "fluid";
  result.kind = kind;
  result.points = points;
  result.quantity = quantity;
  return result;
}

/// The gauges "front", along a line, and "volume".
inline std::vector<Gauge> front_and_volume(const Point3& from, const Point3& to) {
  return {gauge("front", "front", {from, to}), gauge("volume", "volume")};
}

/// Rigid dry ground, 0.4 m deep, below a reservoir face with 0.1 m of water; gauges "front" and "volume".
inline Case ponded_column(double dx) {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = dx;
  scene.soils = {sand()};
  scene.soils[0].shape = box(0.0, 0.0, 0.1, 0.4);
  scene.walls = {wall(line(0.0, 0.5, 0.0, 0.0)), wall(line(0.0, 0.0, 0.1, 0.0)), wall(line(0.1, 0.0, 0.1, 0.5))};
  scene.water_faces = {head_face(line(0.1, 0.4, 0.0, 0.4), 0.5)};
  scene.gauges = front_and_volume(Point3(0.05, 0.4, 0.0), Point3(0.05, 0.0, 0.0));
  return scene;
}

/// Advances in the phase's own windows exactly up to a time; returns the number of windows.
inline std::uint64_t run_to(Phase& phase, double& time, double end, double longest = 1e300) {
  std::uint64_t steps = 0;
  while (time < end * (1.0 - 1e-12)) {
    const double dt = std::min({phase.publish().proposed_interval, longest, end - time});
    phase.advance({steps++, time, dt}, {});
    time += dt;
  }
  return steps;
}

inline double reading(const Phase& phase, const std::string& name) {
  for (const auto& r : phase.gauges())
    if (r.gauge == name) return r.value;
  throw std::runtime_error("no gauge " + name);
}

}  // namespace poretwin::fluid::test
