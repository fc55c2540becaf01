#include "common/case/pace.hpp"

#include "common/case/amounts.hpp"
#include "common/case/materials.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin {
namespace {

/// The largest value of a series; 0 where there is none or it is negative.
double largest(const std::optional<Series>& series) {
  double most = 0.0;
  if (series)
    for (const auto& knot : series->knots) most = std::max(most, knot.second);
  return most;
}

}  // namespace

std::pair<double, std::string> shortest_time(const Case& scene) {
  const double dx = finest_spacing(scene), gravity = scene.general.gravity.norm();
  std::pair<double, std::string> least{HUGE_VAL, ""};
  const auto take = [&](double time, const char* of_what) {
    if (time < least.first) least = {time, of_what};
  };
  const auto way_at = [&](double speed, const char* of_what) {
    if (speed > 0.0) take(dx / speed, of_what);
  };
  constexpr double standard_gravity = 9.81;  // m/s2, for a case without gravity
  const bool falls = !scene.is_field() || scene.deformable();
  if (falls) take(std::sqrt(dx / (gravity > 0.0 ? gravity : standard_gravity)), "a fall through one spacing");
  if (scene.general.central_force > 0.0) take(1.0 / std::sqrt(scene.general.central_force), "the central force");
  if (scene.deformable())
    for (const auto& soil : scene.soils) {
      const double modulus = constrained_modulus(scene, soil);
      way_at(std::sqrt(modulus / ((1.0 - soil.porosity) * soil.grain_density)),
             "a wave of the soil through one spacing");
      way_at(scene.solid.initial_velocity.norm() + std::abs(scene.solid.initial_wave),
             "the way of the soil through one spacing at its initial speed");
    }
  if (scene.has_field()) {
    const double weight = scene.water.density * standard_gravity;
    double head = 0.0;  // m, largest
    for (const auto& face : scene.water_faces)
      head = std::max({head, largest(face.head), largest(face.pressure) / weight});
    for (const auto& soil : scene.soils)
      way_at(soil.hydraulic_conductivity / soil.porosity * (1.0 + head / dx),
             "a front's way through one spacing under the largest head");
  }
  if (scene.has_water() && !scene.is_field()) {
    way_at(scene.water.kinematic_viscosity / dx, "diffusion by viscosity over one spacing");
    way_at(scene.fluid.initial_velocity.norm() + std::abs(scene.fluid.initial_wave) +
               std::abs(scene.fluid.initial_vortices),
           "the way of the water through one spacing at its initial speed");
    double pressure = 0.0;
    for (const auto& face : scene.water_faces)
      pressure = std::max({pressure, largest(face.pressure), largest(face.wave_amplitude)});
    way_at(std::sqrt(2.0 * pressure / scene.water.density),
           "the way through one spacing of a jet from a face's pressure");
    if (scene.fluid.scheme != FluidCase::Scheme::projection)
      for (const auto& soil : scene.soils)
        if (soil.hydraulic_conductivity > 0.0)
          take(soil.hydraulic_conductivity / standard_gravity,
               "the drag on water in soil, which an explicit scheme follows");
  }
  if (scene.coupling.interval) take(*scene.coupling.interval, "coupling.interval");
  if (scene.output.interval > 0.0) take(scene.output.interval, "output.interval");
  if (scene.general.end_time > 0.0) take(scene.general.end_time, "the whole run");
  return least;
}

}  // namespace poretwin
