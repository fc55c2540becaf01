#include "fluid_solver/boundary/inlet.hpp"

#include "common/geometry/shapes.hpp"
#include "fluid_solver/numerics/faces.hpp"
#include "fluid_solver/numerics/points.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin::fluid {

template <int D>
std::vector<Inlet<D>> make_inlets(const Case& scene, const WaterBoundaries& boundaries) {
  std::vector<Inlet<D>> inlets;
  const double dx = scene.fluid.particle_spacing;
  const Vec<D> weight = scene.general.gravity.head<D>();
  const Vec<D> up = weight.norm() > 0.0 ? Vec<D>(-weight.normalized()) : Vec<D>(Vec<D>::Zero());
  for (std::size_t f = 0; f < scene.water_faces.size(); ++f) {
    const auto& face = scene.water_faces[f];
    const bool opening = is_inlet(scene, face);
    if (!opening && boundaries[f]->level(0.0, boundaries[f]->initial())) {
      const auto crest = crest_of(scene, face);
      if (!crest || !no_way_over(scene, *crest).empty()) continue;
      Inlet<D> sill;
      sill.face = static_cast<int>(f);
      sill.sill = true;
      sill.normal = crest->inward.head<D>();
      sill.tangent[0] = sill.normal[1];
      sill.tangent[1] = -sill.normal[0];
      sill.lowest = sill.level = crest->elevation;
      sill.highest = HUGE_VAL;
      sill.foot = crest->end.head<D>();
      sill.open(0.0, dx);
      inlets.push_back(sill);
      continue;
    }
    if (!opening) continue;
    const Vec<D> a = face.face.points.front().head<D>(), b = face.face.points.back().head<D>();
    Inlet<D> inlet;
    inlet.face = static_cast<int>(f);
    inlet.foot = 0.5 * (a + b);
    inlet.width = (b - a).norm();
    inlet.tangent = (b - a) / inlet.width;
    inlet.normal[0] = -inlet.tangent[1];
    inlet.normal[1] = inlet.tangent[0];
    inlet.row = std::max(1, static_cast<int>(std::lround(inlet.width / dx)));
    inlet.spacing = inlet.row * std::pow(dx, D) / inlet.width;
    inlet.lowest = std::min(up.dot(a), up.dot(b));
    inlet.highest = std::max(up.dot(a), up.dot(b));
    inlet.level = inlet.lowest;
    inlets.push_back(inlet);
  }
  return inlets;
}

template <int D>
double inlet_speed(const WaterBoundary& boundary, const FaceState& state, const Inlet<D>& inlet, double dx,
                   double gravity, double time, double interval) {
  double discharge = 0.0;
  if (const auto volume = boundary.let_in(time, time + interval)) {
    discharge = *volume / interval;
  } else {
    const double wanted = boundary.level(time + interval, state).value();
    const double depth = std::max(wanted - inlet.lowest, dx);
    discharge =
        std::sqrt(gravity * depth) * (std::max(wanted, inlet.lowest) - inlet.level) + inlet.current * inlet.width;
  }
  // An opening can draw water in only if all of it lies under water.
  if (discharge < 0.0 && gravity > 0.0 && inlet.level < inlet.highest + 0.5 * inlet.spacing) return 0.0;
  return discharge / inlet.width;
}

SillFlow flow_over(double head, const SillFlow& before, double gravity) {
  if (head <= 0.0) return {};
  const double still = std::sqrt(gravity * head), wave = std::sqrt(gravity * before.depth);
  const double kept = before.speed - 2.0 * wave;
  if (const double out = kept + 2.0 * still; out < 0.0) return before.speed < -wave ? before : SillFlow{head, out};
  const double critical = std::sqrt(2.0 / 3.0) * still;
  const double c = kept >= -critical ? critical : (std::sqrt(3.0 * still * still - 0.5 * kept * kept) - kept) / 3.0;
  return {c * c / gravity, std::min(critical, kept >= -critical ? critical : kept + 2.0 * c)};
}

#define PORETWIN_INSTANTIATE(D)                                                    \
  template std::vector<Inlet<D>> make_inlets(const Case&, const WaterBoundaries&); \
  template double inlet_speed(const WaterBoundary&, const FaceState&, const Inlet<D>&, double, double, double, double);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::fluid
