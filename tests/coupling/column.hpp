// A column of soil for coupled runs, and what is read off them.
#pragma once

#include "tests/coupling/coupled_run.hpp"

#include <cmath>
#include <string>

namespace poretwin::test {

/// The domain lies to the left of the walk.
inline Face line(double ax, double ay, double bx, double by) {
  Face face;
  face.points = {Point3(ax, ay, 0.0), Point3(bx, by, 0.0)};
  return face;
}

/// Porosity 0.4, on a fixed base between rollers (walls 1, 0 and 2); lengths in m.
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

/// A gauge of one point, called as what it reads.
inline Gauge gauge_at(const std::string& phase, const std::string& quantity, double x, double y) {
  Gauge gauge;
  gauge.name = quantity;
  gauge.phase = phase;
  gauge.kind = "point";
  gauge.quantity = quantity;
  gauge.points = {Point3(x, y, 0.0)};
  return gauge;
}

/// What a gauge read last; NaN where it read nothing then.
inline double last(const coupling::MemoryRecorder& record, const std::string& gauge) {
  for (const auto& reading : record.series.back().readings)
    if (reading.gauge == gauge) return reading.value;
  return std::nan("");
}

}  // namespace poretwin::test
