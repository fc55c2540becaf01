// A column of water in and above soil that moves, and what the soil sends to the water: a stand-in for the solid
// solver.
#pragma once

#include "common/coupling/exchange.hpp"
#include "fluid_solver/numerics/exchange.hpp"
#include "tests/tiles/water.hpp"

#include <algorithm>

namespace poretwin::fluid::test {

inline Soil block(const Shape& shape, double conductivity = 1.1e-4) {
  Soil soil = sand();
  soil.hydraulic_conductivity = conductivity;
  soil.shape = shape;
  return soil;
}

/// Soil at rest that drains upwards under a load, or soil that yields and sinks under free water; 100 particles.
inline Case loaded_column(bool yields) {
  Case scene = still();
  scene.solid.model = yields ? SolidCase::Model::drucker_prager : SolidCase::Model::elastic;
  scene.solid.particle_spacing = dx;
  scene.soils = {block(box(0.0, 0.0, 0.1, yields ? 0.3 : 0.4))};
  scene.fluid.regions = {box(0.0, 0.0, 0.1, 0.4)};
  for (const auto& side : {line(0.0, 0.6, 0.0, 0.0), line(0.0, 0.0, 0.1, 0.0), line(0.1, 0.0, 0.1, 0.6)})
    scene.walls.push_back(wall(side));
  if (!yields) scene.water_faces = {pressure_face(line(0.1, 0.4, 0.0, 0.4), 0.0)};
  return scene;
}

/// What the soil of loaded_column() sends to water at these places [m]. Its edge is flat.
inline coupling::Inbox loaded_soil(const VecArray<2>& places, bool yields) {
  const double top = yields ? 0.3 : 0.45;  // m; a drained column has soil beyond its upper face, too
  coupling::Inbox box;
  for (const Vec<2>& x : places) {
    const double outside = (x.y() - top) / dx;
    box.coverage.push_back(std::clamp(0.5 - 0.4 * outside, 0.0, 1.0));
    const auto c = exchange::asymmetry_outside;
    box.asymmetry.push_back(box.coverage.back() > 0.0 ? std::max(0.0, c[0] + outside * (c[1] + outside * c[2])) : 0.0);
  }
  const auto add = [&](std::string_view name, int components, const auto& value) {
    coupling::Field field{std::string(name), components, {}};
    for (const Vec<2>& x : places) {
      if (components == 2) field.values.push_back(0.0);
      field.values.push_back(value(x));
    }
    box.fields.push_back(std::move(field));
  };
  const auto everywhere = [](double value) { return [value](const Vec<2>&) { return value; }; };
  const auto sinks = [yields](const Vec<2>& x) { return yields ? -0.1 * x.y() : 0.0; };
  add(coupling::field::solid_velocity, 2, sinks);
  add(coupling::field::mean_solid_velocity, 2, sinks);
  add(coupling::field::volumetric_strain_rate, 1, everywhere(yields ? -0.09 : 0.0));
  add(coupling::field::unbalanced_force, 2, [](const Vec<2>& x) { return -1e4 - 2e4 * x.y(); });
  add(coupling::field::solid_volume_fraction, 1, everywhere(0.6));
  add(coupling::field::grain_density, 1, everywhere(2600.0));
  add(coupling::field::constrained_modulus, 1, [](const Vec<2>& x) { return x.y() > 0.1 ? 4e6 : 1e6; });
  add(coupling::field::yielding, 1, everywhere(yields ? 0.8 : 0.0));
  add(coupling::field::hydraulic_conductivity, 1, everywhere(1e-4));
  add(coupling::field::forchheimer_coefficient, 1, everywhere(0.0));
  add(coupling::field::returned_impulse, 2, everywhere(1e-5));
  return box;
}

}  // namespace poretwin::fluid::test
