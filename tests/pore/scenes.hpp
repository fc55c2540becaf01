// Small cases in memory, and a driver for pore water alone.
#pragma once

#include "common/case/case.hpp"
#include "common/media/retention_law.hpp"
#include "pore_solver/pore_phase.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace poretwin::pore::test {

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

inline Series constant(double value) { return Series{{{0.0, value}}}; }

inline WaterFace head_face(Face face, double head) {
  WaterFace w;
  w.face = std::move(face);
  w.head = constant(head);
  return w;
}
inline WaterFace pressure_face(Face face, double head) {
  WaterFace w;
  w.face = std::move(face);
  w.pressure = constant(9810.0 * head);
  return w;
}
inline Rain rain(Face face, Series rate) {
  Rain r;
  r.face = std::move(face);
  r.rate = std::move(rate);
  return r;
}

inline const porous::RetentionLaw* law(const std::string& name) {
  for (const auto& one : porous::retention_laws())
    if (one.name == name) return &one;
  return nullptr;
}

inline Soil van_genuchten(double theta_r, double theta_s, double alpha, double n, double k) {
  Soil soil;
  soil.porosity = theta_s;
  soil.hydraulic_conductivity = k;
  soil.retention.emplace();
  soil.retention->law = law("van_genuchten");
  soil.retention->residual_water_content = theta_r;
  soil.retention->numbers = {{"alpha", alpha}, {"n", n}, {"entry_head", 0.0}, {"pore_connectivity", 0.5}};
  return soil;
}
inline Soil gardner(double theta_r, double theta_s, double alpha, double k) {
  Soil soil = van_genuchten(theta_r, theta_s, alpha, 2.0, k);
  soil.retention->law = law("gardner");
  return soil;
}
inline Soil sharp(double porosity, double k) {
  Soil soil;
  soil.porosity = porosity;
  soil.hydraulic_conductivity = k;
  return soil;
}

/// Soil of a shape, with points a spacing apart.
inline Case scene_of(Soil soil, const Shape& shape, double spacing, double end) {
  Case scene;
  scene.general.end_time = end;
  scene.solid.model = MaterialName::rigid;
  scene.fluid.representation = FluidCase::Representation::field;
  scene.fluid.particle_spacing = spacing;
  soil.shape = shape;
  scene.soils = {std::move(soil)};
  return scene;
}

/// A column one point wide from z = 0 up.
inline Case column(Soil soil, double height, double spacing, double end) {
  return scene_of(std::move(soil), box(0.0, 0.0, spacing, height), spacing, end);
}
inline Face base_of(double spacing) { return line(0.0, 0.0, spacing, 0.0); }
inline Face top_of(double spacing, double height) { return line(spacing, height, 0.0, height); }

/// Advances up to a time, in windows as long as the phase proposes.
inline void run_to(PoreWater& water, double time) {
  std::uint64_t step = 0;
  double limit = HUGE_VAL;
  while (water.state().time < time * (1.0 - 1e-12)) {
    const double left = time - water.state().time;
    const double interval = std::min({left, limit, water.proposal().first});
    const auto outcome = water.advance({++step, water.state().time, interval}, {});
    limit = outcome.accepted ? HUGE_VAL : outcome.suggested_interval;
  }
}

inline double reading(const PoreWater& water, const std::string& name) {
  for (const auto& r : water.gauges())
    if (r.gauge == name) return r.value;
  return std::numeric_limits<double>::quiet_NaN();
}

inline Gauge gauge(const std::string& name, const std::string& kind, std::vector<Point3> points = {},
                   const std::string& quantity = {}) {
  Gauge g;
  g.name = name;
  g.phase = "fluid";
  g.kind = kind;
  g.points = std::move(points);
  g.quantity = quantity;
  return g;
}

/// Points at these elevations in a column.
inline std::vector<Point3> up(double x, const std::vector<double>& elevations) {
  std::vector<Point3> points;
  for (const double z : elevations) points.emplace_back(x, z, 0.0);
  return points;
}

}  // namespace poretwin::pore::test
