// A column of soil for coupled runs, and its gauges.
#pragma once

#include "tests/coupling/coupled_run.hpp"

#include <cmath>
#include <string>

namespace poretwin::test {

/// A wall line from a to b; the domain lies on its left.
inline Face line(double ax, double ay, double bx, double by) {
  Face face;
  face.points = {Point3(ax, ay, 0.0), Point3(bx, by, 0.0)};
  return face;
}

/// Soil of porosity 0.4 on a fixed base (wall 1) between rollers (walls 0 and 2); lengths in m.
inline Case soil_column(double width, double height, double spacing) {
  Case scene;
  Soil soil;
  soil.name = "sand";
  soil.shape.max = Point3(width, height, 0.0);
  soil.porosity = 0.4;
  soil.grain_density = 2600.0;
  soil.hydraulic_conductivity = 1e-4;
  scene.soils = {soil};
  scene.solid.particle_spacing = scene.fluid.particle_spacing = spacing;
  for (const auto& face : {line(0, height, 0, 0), line(0, 0, width, 0), line(width, 0, width, height)}) {
    Wall wall;
    wall.face = face;
    scene.walls.push_back(wall);
  }
  scene.walls[1].soil = Wall::ForSoil::fixed;
  return scene;
}

/// A gauge at one point, named after the quantity that it reads.
inline Gauge gauge_at(const std::string& phase, const std::string& quantity, double x, double y) {
  Gauge gauge;
  gauge.name = quantity;
  gauge.phase = phase;
  gauge.kind = "point";
  gauge.quantity = quantity;
  gauge.points = {Point3(x, y, 0.0)};
  return gauge;
}

/// The last reading of a gauge; NaN where it then had none.
inline double last(const coupling::MemoryRecorder& record, const std::string& gauge) {
  for (const auto& reading : record.series.back().readings)
    if (reading.gauge == gauge) return reading.value;
  return std::nan("");
}

}  // namespace poretwin::test
