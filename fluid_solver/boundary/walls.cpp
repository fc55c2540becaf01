#include "fluid_solver/boundary/walls.hpp"

#include "common/core/error.hpp"
#include "common/geometry/shapes.hpp"
#include "common/geometry/surfaces.hpp"
#include "common/geometry/thin_walls.hpp"
#include "fluid_solver/discretisation/stencil.hpp"
#include "fluid_solver/numerics/faces.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace poretwin::fluid {

template <int D>
std::vector<sph::ImagePlane<D>> water_planes(const Case& scene, const std::vector<Inlet<D>>& inlets, double margin) {
  std::vector<sph::ImagePlane<D>> planes;
  for (std::size_t w = 0; w < scene.walls.size(); ++w)
    if (scene.walls[w].water != Wall::ForWater::none && !scene.walls[w].shape)
      for (const auto& plane : planes_of<D>(scene.walls[w].face, static_cast<int>(w), 0.0)) planes.push_back(plane);
  for (const auto& inlet : inlets)
    if (!inlet.sill)
      planes.push_back(
          planes_of<D>(scene.water_faces[static_cast<std::size_t>(inlet.face)].face, piston_boundary, 0.0)[0]);
  meet_at_corners<D>(std::span(planes), margin);
  for (const auto& plane : periodic_planes<D>(scene.general, periodic_boundary)) planes.push_back(plane);
  return planes;
}

template <int D>
sph::Sight<D> water_sight(const Case& scene, double margin) {
  if constexpr (D == 2) {
    if (!sight_matters(scene, Keeps::water)) return {};
    auto planes = sides_of_walls(scene, Keeps::water, margin);
    return sph::Sight<D>(std::move(planes), sight_slack * margin);
  } else {
    return {};
  }
}

std::shared_ptr<const Surfaces> water_surfaces(const Case& scene) {
  const auto for_water = [](const Wall& wall) { return wall.water != Wall::ForWater::none; };
  if (std::ranges::none_of(scene.walls, [&](const Wall& wall) { return for_water(wall) && wall.shape; }))
    return nullptr;
  auto surfaces = std::make_shared<Surfaces>();
  for (std::size_t w = 0; w < scene.walls.size(); ++w) {
    if (for_water(scene.walls[w])) surfaces->add(scene.walls[w], static_cast<int>(w));
  }
  return surfaces;
}

template <int D>
Walls<D>::Walls(const Case& scene, const std::vector<Inlet<D>>& inlets)
    : margin_(wall_margin * sph::support_radius * points::smoothing_ratio * scene.fluid.particle_spacing) {
  sight = water_sight<D>(scene, margin_);
  if (sight.limited())
    at_first_.assign(sight.planes().begin(), sight.planes().end());
  else
    at_first_ = water_planes<D>(scene, inlets, margin_);
  if (D == 3) surfaces = water_surfaces(scene);
  place(inlets);
}

template <int D>
void Walls<D>::place(const std::vector<Inlet<D>>& inlets) {
  planes.clear();
  // Pistons of sills extend up from the crest. They come before the walls: a floor on the crest mirrors their images.
  for (const auto& inlet : inlets) {
    if (!inlet.sill || !inlet.flows) continue;
    sph::ImagePlane<D> plane;
    plane.normal = inlet.normal;
    plane.tangent = inlet.tangent;
    plane.to = inlet.tangent.dot(inlet.foot) + 0.5 * inlet.width;
    plane.from = plane.to - 1e6 * margin_;
    plane.boundary = sill_boundary;
    plane.point = inlet.foot + inlet.piston * inlet.normal;
    plane.speed = inlet.speed;
    planes.push_back(plane);
  }
  std::size_t next = planes.size();
  planes.insert(planes.end(), at_first_.begin(), at_first_.end());
  for (const auto& inlet : inlets) {
    if (inlet.sill) continue;
    while (planes[next].boundary != piston_boundary) ++next;
    planes[next].point += inlet.piston * inlet.normal;
    planes[next++].speed = inlet.speed;
  }
}

template <int D>
void Walls<D>::expect_before(std::span<const Vec<D>> points) const {
  if constexpr (D == 3) {
    if (!surfaces) return;
    for (const auto& x : points)
      if (!surfaces->holds(x))
        throw CaseError(fmt::format(
            "a particle of water at [{:.6g}, {:.6g}, {:.6g}] m lies behind a [[wall]] with a shape; expected every "
            "[[fluid.region]] on the right side of it: cut the region by 'within' or 'without' with the wall's shape",
            x.x(), x.y(), x.z()));
  }
}

#define PORETWIN_INSTANTIATE(D)                                                                             \
  template std::vector<sph::ImagePlane<D>> water_planes(const Case&, const std::vector<Inlet<D>>&, double); \
  template sph::Sight<D> water_sight(const Case&, double);                                                  \
  template struct Walls<D>;
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::fluid
