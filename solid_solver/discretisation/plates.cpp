#include "solid_solver/discretisation/plates.hpp"

#include "common/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace poretwin::solid {

template <int D>
Vec<D> PlateSetup<D>::prescribed(double time) const {
  Vec<D> moved = Vec<D>::Zero();
  const double since = std::max(time, 0.0);  // before time zero, the soil comes to rest
  if (displacement) moved += displacement->at(since) * normal;
  if (speed) moved += speed->integral(0.0, since) * normal;
  if (slide) moved += slide->at(since) * along;
  return moved;
}

template <int D>
double PlateSetup<D>::force_at(double time) const {
  return force && time >= start ? force->at(time) : 0.0;
}

template <int D>
double PlateSetup<D>::moment_at(double time) const {
  return moment && time >= start ? moment->at(time) : 0.0;
}

template <int D>
std::vector<PlateSetup<D>> make_plates(const Case& scene, double spacing, const VecArray<D>& position,
                                       const ScalarArray& mass) {
  std::vector<PlateSetup<D>> plates;
  for (const Plate& given : scene.plates) {
    PlateSetup<D>& plate = plates.emplace_back();
    plate.name = given.name;
    plate.displacement = given.displacement;
    plate.speed = given.speed;
    plate.force = given.force;
    plate.slide = given.along;
    if (given.start) plate.start = *given.start;
    plate.tilts = given.tilts;
    plate.lifts = given.lifts;
    plate.eccentricity = given.eccentricity.value_or(0.0);
    plate.moment = given.moment;
    for (const auto& plane : plate_planes<D>(given)) {
      plate.normal = plane.normal;
      plate.along = plane.tangent;
      if constexpr (D == 2)
        if (plane.tangent.isZero()) plate.along = Vec<2>(plane.normal.y(), -plane.normal.x());
      plate.half = 0.5 * (plane.to - plane.from);
      plate.middle = plane.at(0.5 * (plane.from + plane.to));
      for (std::size_t i = 0; i < position.size(); ++i) {
        const double distance = plane.normal.dot(position[i] - plane.point);
        if (distance <= 0.0 || distance >= spacing) continue;
        if (plane.faces(position[i])) {
          plate.row += mass[i];
          plate.row_inertia += mass[i] * std::pow(plate.along.dot(position[i] - plate.middle), 2);
        } else if (plane.beyond(position[i]) < spacing)
          plate.sinks_in = true;
      }
    }
    if (!(plate.row > 0.0))
      throw CaseError(
          fmt::format("plate \"{}\": no soil particle lies within a spacing before it; move it to the soil's "
                      "surface",
                      plate.name));
    plate.mass = given.mass.value_or(plate.row);
    plate.inertia = given.mass ? plate.mass * plate.half * plate.half / 3.0 : plate.row_inertia;  // of a uniform bar
  }
  return plates;
}

template <int D>
std::vector<PlateOrder<D>> orders_at(const std::vector<PlateSetup<D>>& plates, double time) {
  std::vector<PlateOrder<D>> orders;
  for (const PlateSetup<D>& plate : plates)
    orders.push_back({plate.prescribed(time), plate.force_at(time), plate.moment_at(time)});
  return orders;
}

template <int D>
std::vector<PlateFreedom> freedoms_of(const std::vector<PlateSetup<D>>& plates) {
  std::vector<PlateFreedom> freedoms;
  for (std::size_t k = 0; k < plates.size(); ++k)
    if (plates[k].is_free()) freedoms.push_back({k, false});
  for (std::size_t k = 0; k < plates.size(); ++k)
    if (plates[k].tilts) freedoms.push_back({k, true});
  return freedoms;
}

#define PORETWIN_INSTANTIATE(D)                                                                                    \
  template struct PlateSetup<D>;                                                                                   \
  template std::vector<PlateSetup<D>> make_plates<D>(const Case&, double, const VecArray<D>&, const ScalarArray&); \
  template std::vector<PlateOrder<D>> orders_at<D>(const std::vector<PlateSetup<D>>&, double);                     \
  template std::vector<PlateFreedom> freedoms_of<D>(const std::vector<PlateSetup<D>>&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::solid
