#include "common/case/origin.hpp"

#include "common/case/amounts.hpp"
#include "common/geometry/solid.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin {
namespace {

/// Calls f with every position in the case; if not `of_planes`, without those of planes, which may lie anywhere.
template <class F>
void for_each_place(Case& scene, F&& f, bool of_planes = true) {
  const auto shape = [&](Shape& s) {
    if (s.solid) {
      auto [lower, upper] = s.solid->bounds();
      const Point3 before = lower;
      f(lower);
      f(upper);
      if (lower == before) return;
      s.solid = std::make_shared<const Solid>(s.solid->moved(lower - before));
      s.placement = s.placement.value_or(Placement{});
      s.placement->move += lower - before;
      return;
    }
    if (s.kind == Shape::Kind::box) {
      f(s.min);
      f(s.max);
    }
    for (auto& x : s.points) f(x);
    if (s.kind == Shape::Kind::ball) f(s.centre);
  };
  const auto face = [&](Face& g) {
    for (auto& x : g.points) f(x);
    if (of_planes && g.points.empty()) f(g.point);
    if (of_planes && g.within) shape(*g.within);
  };
  for (auto& soil : scene.soils) shape(soil.shape);
  for (auto& region : scene.fluid.regions) shape(region);
  for (auto& wall : scene.walls)
    if (wall.shape)
      shape(*wall.shape);
    else
      face(wall.face);
  for (auto& water_face : scene.water_faces) face(water_face.face);
  for (auto& rain : scene.rains) face(rain.face);
  for (auto& well : scene.wells)
    for (auto& x : well.points) f(x);
  for (auto& load : scene.loads) face(load.face);
  for (auto& plate : scene.plates) face(plate.face);
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
  for_each_place(
      scene,
      [&](const Point3& x) {
        lower = lower.cwiseMin(x);
        upper = upper.cwiseMax(x);
      },
      false);
  // The phase of a standing wave is measured from x = 0.
  const bool waves = std::any_of(scene.water_faces.begin(), scene.water_faces.end(),
                                 [](const WaterFace& face) { return face.wave_amplitude.has_value(); });
  const double spacing = finest_spacing(scene);
  if (!(spacing > 0.0)) return;  // check_case() complains
  // A scene nearer to the origin than this is not moved, since the rounding of its coordinates does not matter (the
  // error of a yielding slope is 1e-6 at 1e3 spacings and 3e-5 at 1e5). A scene wider than its distance from the origin
  // is not moved either: moving it would gain no digits.
  constexpr double far = 1e3;  // spacings
  // The displacement is an integer times a power of two, so that coordinates lose no digits.
  const double step = std::exp2(std::floor(std::log2(spacing)));
  Point3 way = Point3::Zero();
  for (int d = 0; d < g.dimension; ++d)
    if (g.gravity[d] == 0.0 && !(waves && d == 0) &&
        std::max(lower[d], -upper[d]) > std::max(upper[d] - lower[d], far * spacing))
      way[d] = std::floor(lower[d] / step) * step;
  if (way.isZero()) return;
  scene.general.origin = way;
  for_each_place(scene, [&](Point3& x) { x -= way; });
  // The periodic box may be given for some of the axes only.
  for (int d = 0; d < g.dimension; ++d)
    if (g.domain_max[d] > g.domain_min[d])
      for (auto* corner : {&scene.general.domain_min, &scene.general.domain_max}) (*corner)[d] -= way[d];
}

}  // namespace poretwin
