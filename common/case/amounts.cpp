#include "common/case/amounts.hpp"

#include "common/geometry/shapes.hpp"
#include "common/geometry/solid.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace poretwin {
namespace {

/// Number of lattice rows that fill() makes along a length.
double rows(double length, double spacing) { return std::max(1.0, std::round(length / spacing)); }

double particles_in(const Shape& shape, double spacing, int dimension) {
  if (!(spacing > 0.0)) return 0.0;
  if (shape.solid || shape.kind != Shape::Kind::box) return measure(shape, dimension) / std::pow(spacing, dimension);
  double count = 1.0;
  for (int d = 0; d < dimension; ++d) count *= rows(shape.max[d] - shape.min[d], spacing);
  return count;
}

/// Number of output times: time zero, the end, and the multiples of `interval` between them (if it is not 0).
double instants(double end, double interval) { return interval > 0.0 ? std::floor(end / interval) + 1.0 : 2.0; }

}  // namespace

double measure(const Shape& shape, int dimension) {
  if (shape.solid) return shape.solid->volume();
  if (shape.kind == Shape::Kind::ball)
    return dimension == 3 ? 4.0 / 3.0 * std::numbers::pi * std::pow(shape.radius, 3)
                          : std::numbers::pi * shape.radius * shape.radius;
  if (shape.kind == Shape::Kind::box) {
    double product = 1.0;
    for (int d = 0; d < dimension; ++d) product *= shape.max[d] - shape.min[d];
    return product;
  }
  double twice = 0.0;  // twice the signed area, by the shoelace formula
  const auto& p = shape.points;
  for (std::size_t i = 0, j = p.size() - 1; i < p.size(); j = i++)
    twice += (p[j].x() - p[0].x()) * (p[i].y() - p[0].y()) - (p[i].x() - p[0].x()) * (p[j].y() - p[0].y());
  return 0.5 * std::abs(twice);
}

Amounts estimate(const Case& scene) {
  Amounts a;
  const int dimension = scene.general.dimension;
  if (scene.has_field())
    for (const auto& soil : scene.soils) a.fluid += particles_in(soil.shape, scene.fluid.particle_spacing, dimension);
  if (!scene.is_field())
    for (const auto& region : scene.fluid.regions)
      a.fluid += particles_in(region, scene.fluid.particle_spacing, dimension);
  a.fluid_full = a.fluid;
  if (!scene.has_field() && !scene.water_faces.empty())
    for (const auto& soil : scene.soils)
      a.fluid_full += particles_in(soil.shape, scene.fluid.particle_spacing, dimension);
  if (scene.deformable())
    for (const auto& soil : scene.soils) a.solid += particles_in(soil.shape, scene.solid.particle_spacing, dimension);
  a.frames = instants(scene.general.end_time, scene.output.interval);
  // Doubles per particle and frame: three coordinates and the fields that the phases declare.
  constexpr double fluid_numbers = 13.0, solid_numbers = 26.0;
  a.frame_bytes = 8.0 * a.frames * (fluid_numbers * a.fluid + solid_numbers * a.solid);
  if (scene.output.gauge_interval > 0.0)
    for (const auto& gauge : scene.gauges)
      a.gauge_rows +=
          instants(scene.general.end_time, scene.output.gauge_interval) *
          (gauge.kind == "point" || gauge.kind == "height" ? static_cast<double>(gauge.points.size()) : 1.0);
  // Bytes of state, neighbour lists and exchange per particle; 3D particles have four to five times as many neighbours.
  // A point of a field has few neighbours: most of its memory holds the search directions of the linear solver.
  // Measured: 2.2 kB per point, for 97,600 points in 3D.
  const double of_particle = dimension == 3 ? 12e3 : 3e3, of_point = 3e3;
  a.memory_bytes = 40e6 + (scene.is_field() ? of_point : of_particle) * a.fluid + of_particle * a.solid;
  // Bytes per soil particle for its stiffness and the multigrid levels, measured with 22,760 and 50,000 particles.
  constexpr double of_stiffness = 3e3;
  if (dimension == 3 && scene.coupled()) a.memory_bytes += of_stiffness * a.solid;
  return a;
}

double finest_spacing(const Case& scene) {
  if (!scene.deformable()) return scene.fluid.particle_spacing;
  if (!scene.has_water()) return scene.solid.particle_spacing;
  return std::min(scene.fluid.particle_spacing, scene.solid.particle_spacing);
}

double spacing_to_look_at(const Shape& shape, double spacing, int dimension) {
  if (!(spacing > 0.0)) return spacing;
  constexpr double most = 1e5;
  const auto [lower, upper] = bounds(shape);
  double count = 1.0;
  for (int d = 0; d < dimension; ++d) count *= rows(upper[d] - lower[d], spacing);
  return count > most ? spacing * std::pow(count / most, 1.0 / dimension) : spacing;
}

std::vector<Point3> places_in(const Shape& shape, double spacing, int dimension) {
  std::vector<Point3> result;
  const double apart = spacing_to_look_at(shape, spacing, dimension);
  const auto take = [&](const auto& lattice) {
    for (const auto& x : lattice.position) {
      Point3 point = Point3::Zero();
      point.head(x.size()) = x;
      result.push_back(point);
    }
  };
  if (dimension == 3)
    take(fill<3>(shape, apart, {0.5, 0.5, 0.5}, 0.0, 1));
  else
    take(fill<2>(shape, apart, {0.5, 0.5, 0.5}, 0.0, 1));
  return result;
}

}  // namespace poretwin
