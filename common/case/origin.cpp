#include "common/case/origin.hpp"

#include "common/case/amounts.hpp"
#include "common/case/geometry.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin {
namespace {

/// Calls f with every place that the case names.
template <class F>
void for_each_place(Case& scene, F&& f) {
  const auto shape = [&](Shape& s) {
    if (s.kind == Shape::Kind::box) {
      f(s.min);
      f(s.max);
    }
    for (auto& x : s.points) f(x);
    if (s.kind == Shape::Kind::ball) f(s.centre);
  };
  const auto face = [&](Face& g) {
    for (auto& x : g.points) f(x);
    if (g.points.empty()) f(g.point);
  };
  for (auto& soil : scene.soils) shape(soil.shape);
  for (auto& region : scene.fluid.regions) shape(region);
  for (auto& wall : scene.walls) face(wall.face);
  for (auto& water_face : scene.water_faces) face(water_face.face);
  for (auto& load : scene.loads) face(load.face);
  for (auto& p : scene.pore_pressures) {
    if (p.region) shape(*p.region);
    if (p.to_head) {
      f(p.from);
      f(p.to);
    }
  }
  for (auto& gauge : scene.gauges) {
    for (auto& x : gauge.points) f(x);
    if (gauge.region) shape(*gauge.region);
  }
}

}  // namespace

void move_to_origin(Case& scene) {
  const auto& g = scene.general;
  if (g.central_force != 0.0 || scene.fluid.initial_strain != 0.0 || scene.fluid.initial_vortices != 0.0) return;
  Point3 lower = Point3::Constant(HUGE_VAL), upper = -lower;
  const auto enclose = [&](const Shape& s) {
    if (s.kind == Shape::Kind::polygon && s.points.empty()) return;
    const auto [low, high] = bounds(s);
    lower = lower.cwiseMin(low);
    upper = upper.cwiseMax(high);
  };
  for (const auto& soil : scene.soils) enclose(soil.shape);
  for (const auto& region : scene.fluid.regions) enclose(region);
  const double spacing = finest_spacing(scene);
  constexpr double far = 1e5;    // spacings; wrong numbers begin beyond 2e6
  if (!(spacing > 0.0)) return;  // check_case() complains
  Point3 way = Point3::Zero();
  for (int d = 0; d < g.dimension; ++d)
    if (g.gravity[d] == 0.0 && lower[d] <= upper[d] && std::max(std::abs(lower[d]), std::abs(upper[d])) > far * spacing)
      way[d] = std::floor(lower[d]);
  if (way.isZero()) return;
  scene.general.origin = way;
  for_each_place(scene, [&](Point3& x) { x -= way; });
  // The box is given as a whole, or for some axes only.
  for (int d = 0; d < g.dimension; ++d)
    if (g.domain_max[d] > g.domain_min[d])
      for (auto* corner : {&scene.general.domain_min, &scene.general.domain_max}) (*corner)[d] -= way[d];
}

}  // namespace poretwin
