#include "fluid_solver/boundary/basin.hpp"

#include "common/core/error.hpp"
#include "common/geometry/shapes.hpp"

#include <fmt/format.h>

#include <cmath>

namespace poretwin::fluid {

Basin::Basin(const Case& scene, const WaterFace& face) : area_(*face.basin_area), inflow_(*face.discharge) {
  first_level_ = basin_first_level(face);
  face_ = fmt::format("water_face[{}]{}", &face - scene.water_faces.data(),
                      face.name.empty() ? "" : " \"" + face.name + "\"");
  const auto crest = crest_of(scene, face);
  if (!crest) return;
  why_not_over_ = no_way_over(scene, *crest);
  if (!why_not_over_.empty()) crest_ = crest->elevation;
}

void Basin::check(double time, const FaceState& state) const {
  if (state.level <= crest_) return;
  throw DivergedError(fmt::format(
      "fluid: the basin behind {} has risen to {:.4g} m at t = {:.4g} s, above the face's upper end at {:.4g} m, and "
      "cannot run over there: {}; give it less discharge or more area, a wall up to the level, or a reservoir of real "
      "water (an inlet away from the soil)",
      face_, state.level, time, crest_, why_not_over_));
}

/// The longest window in which the level moves by at most the allowed rise, both at the present inflow and at the
/// inflow of the table, which may begin or increase within the window.
TimeLimit Basin::limit(double now, const AllowedChange& allowed, const FaceState& state) const {
  const double room = allowed.rise * area_.at(state.level), inflow = std::abs(inflow_.at(now));
  double longest = inflow > 0.0 ? std::min(allowed.longest, room / inflow) : allowed.longest;
  for (int halvings = 0; halvings < 100 && std::abs(inflow_.integral(now, now + longest)) > 1.001 * room; ++halvings)
    longest *= 0.5;
  return {longest, "rise of a basin"};
}

}  // namespace poretwin::fluid
