#include "fluid_solver/boundary/inlet.hpp"

#include "common/geometry/shapes.hpp"
#include "common/geometry/thin_walls.hpp"
#include "fluid_solver/fluid_phase.hpp"
#include "fluid_solver/numerics/faces.hpp"

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
  // An opening draws water as far as it lies under water.
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

template <int D>
std::vector<sph::ImagePlane<D>> water_planes(const Case& scene, const std::vector<Inlet<D>>& inlets, double margin) {
  std::vector<sph::ImagePlane<D>> planes;
  // Sills' pistons, from the crest up, before the walls: a floor on the crest mirrors what they mirror.
  for (const auto& inlet : inlets) {
    if (!inlet.sill || !inlet.flows) continue;
    sph::ImagePlane<D> plane;
    plane.normal = inlet.normal;
    plane.tangent = inlet.tangent;
    plane.to = inlet.tangent.dot(inlet.foot) + 0.5 * inlet.width;
    plane.from = plane.to - 1e6 * margin;
    plane.boundary = sill_boundary;
    plane.point = inlet.foot + inlet.piston * inlet.normal;
    plane.speed = inlet.speed;
    planes.push_back(plane);
  }
  const std::size_t sills = planes.size();
  for (std::size_t w = 0; w < scene.walls.size(); ++w)
    if (scene.walls[w].water != Wall::ForWater::none)
      for (const auto& plane : planes_of<D>(scene.walls[w].face, static_cast<int>(w), 0.0)) planes.push_back(plane);
  const std::size_t walls = planes.size();
  for (const auto& inlet : inlets)
    if (!inlet.sill)
      planes.push_back(
          planes_of<D>(scene.water_faces[static_cast<std::size_t>(inlet.face)].face, piston_boundary, 0.0)[0]);
  meet_at_corners<D>(std::span(planes).subspan(sills), margin);
  std::size_t next = walls;
  for (const auto& inlet : inlets) {
    if (inlet.sill) continue;
    planes[next].point += inlet.piston * inlet.normal;
    planes[next++].speed = inlet.speed;
  }
  for (const auto& plane : periodic_planes<D>(scene.general, periodic_boundary)) planes.push_back(plane);
  return planes;
}

template <int D>
sph::Sight<D> water_sight(const Case& scene, double margin) {
  if constexpr (D == 2) {
    if (!sight_matters(scene)) return {};
    auto planes = sides_of_walls(scene, margin);
    return sph::Sight<D>(std::move(planes), sight_slack * margin);
  } else {
    return {};
  }
}

template <int D>
void Fluid<D>::place_pistons() {
  const double margin = wall_margin * sph::support_radius * points::smoothing_ratio * dx_;
  if (sight_.limited() || planes_.empty()) sight_ = water_sight<D>(scene_, margin);
  if (sight_.limited())
    planes_.assign(sight_.planes().begin(), sight_.planes().end());
  else
    planes_ = water_planes<D>(scene_, state_.inlets, margin);
}

template <int D>
bool Fluid<D>::is_opening(int face) const {
  return std::any_of(state_.inlets.begin(), state_.inlets.end(),
                     [&](const auto& inlet) { return inlet.face == face && !inlet.sill; });
}

/// What the inlets do in the window that begins: the levels before them from the free water's surface near by.
template <int D>
void Fluid<D>::set_inlets(double time, double interval) {
  if (state_.inlets.empty()) return;
  const auto& p = state_.particles;
  const double near = 4.0 * dx_;
  const Vec<D> up = weight_.norm() > 0.0 ? Vec<D>(-weight_.normalized()) : Vec<D>(Vec<D>::Zero());
  double lowest = HUGE_VAL, highest = -HUGE_VAL;
  Vec<D> least = Vec<D>::Constant(HUGE_VAL), most = -least;  // of free water's places
  for (std::size_t a = 0; a < p.size(); ++a) {
    if (p.mask[a] > 0.5 || p.surface[a] == Surface::lone) continue;
    lowest = std::min(lowest, up.dot(p.position[a]) - 0.5 * dx_);
    highest = std::max(highest, up.dot(p.position[a]) + 0.5 * dx_);
    least = least.cwiseMin(p.position[a]);
    most = most.cwiseMax(p.position[a]);
  }
  if (highest > lowest)
    state_.wave_speed = std::max(state_.wave_speed, std::sqrt(scene_.general.gravity.norm() * (highest - lowest)));
  for (auto& inlet : state_.inlets) {
    double level = 0.0, surface = 0.0, head = 0.0, water = 0.0, moving = 0.0, speed = 0.0;
    const double half = 0.5 * inlet.width * (inlet.tangent - up.dot(inlet.tangent) * up).norm();
    for (std::size_t a = 0; a < p.size(); ++a) {
      const Vec<D> way = p.position[a] - inlet.foot;
      const double height = up.dot(p.position[a]), aside = (way - up.dot(way) * up).norm();
      if (p.mask[a] > 0.5 || height < inlet.lowest || aside > half + near) continue;
      if (p.surface[a] != Surface::lone) {
        moving += p.mass[a];
        speed += p.mass[a] * inlet.normal.dot(p.velocity[a]);
      }
      if (p.surface[a] == Surface::surface) {
        surface += 1.0;
        level += height + 0.5 * spacing_of<D>(p.volume[a]) * p.row[a];
      } else if (p.surface[a] == Surface::interior && inlet.before(p.position[a]) &&
                 inlet.depth(p.position[a]) < 2.0 * inlet.spacing) {
        water += 1.0;
        head += p.pressure[a];
      }
    }
    // A pipe that runs full has no surface.
    if (surface > 0.0)
      inlet.level = level / surface;
    else if (inlet.sill)
      inlet.level = inlet.lowest;
    else
      inlet.level = water > 0.0 ? head / (water * weight_.norm()) + up.dot(origin_) : inlet.lowest;
    if (inlet.sill) {
      const double over = level_behind(inlet.face, time).value() - inlet.lowest;
      // Water in front of a piston moves with it: its present speed would only repeat what the piston did.
      const double averaging_time = faces::current_waves * near / std::sqrt(gravity_or_standard_ * std::max(dx_, over));
      inlet.current +=
          std::min(1.0, interval / averaging_time) * ((moving > 0.0 ? speed / moving : 0.0) - inlet.current);
      const auto flow =
          flow_over(over, {std::max(0.0, inlet.level - inlet.lowest), inlet.current}, gravity_or_standard_);
      inlet.flows = over > 0.0;
      inlet.speed = flow.speed;
      inlet.open(flow.depth, dx_);
    } else {
      if (const auto wanted = level_behind(inlet.face, time); wanted && highest > lowest) {
        // Water of length L responds to a discharge within L / sqrt(g d). Correcting the current over four times that
        // avoids oscillation. The missing head counts up to one spacing: a reservoir that fills draws nothing off.
        const double wave = std::sqrt(gravity_or_standard_ * std::max(dx_, *wanted - inlet.lowest));
        const double missing = std::clamp(*wanted - inlet.level, -dx_, dx_);
        const double length = std::max(dx_, (most - least).norm());  // one particle is a spacing long
        inlet.current += interval * wave * wave / (4.0 * length) * missing / inlet.width;
      }
      const auto f = static_cast<std::size_t>(inlet.face);
      inlet.speed =
          inlet_speed(*boundaries_[f], state_.faces[f], inlet, dx_, scene_.general.gravity.norm(), time, interval);
      if (inlet.speed == 0.0) inlet.current = std::max(0.0, inlet.current);  // an opening that cannot draw
    }
    const double volume = inlet.speed * inlet.width * interval;
    (volume > 0.0 ? state_.balance.in : state_.balance.out) += std::abs(volume);
  }
}

template <int D>
void Fluid<D>::push_pistons(double interval) {
  if (state_.inlets.empty()) return;
  for (auto& inlet : state_.inlets) inlet.piston += interval * inlet.speed;
  place_pistons();
}

/// Rows for what pistons pushed in, and water taken away that has followed them out.
template <int D>
void Fluid<D>::serve_inlets() {
  if (state_.inlets.empty()) return;
  auto& p = state_.particles;
  for (auto& inlet : state_.inlets) {
    while (inlet.piston >= 0.5 * inlet.spacing) {
      double pressure = 0.0, count = 0.0;
      for (std::size_t a = 0; a < p.size(); ++a)
        if (inlet.before(p.position[a]) && std::abs(inlet.depth(p.position[a])) < inlet.spacing) {
          pressure += p.pressure[a];
          count += 1.0;
        }
      inlet.piston -= inlet.spacing;
      const double volume = inlet.width * inlet.spacing / inlet.row;
      for (int i = 0; i < inlet.row; ++i) {
        const Vec<D> x = inlet.foot + ((i + 0.5) / inlet.row - 0.5) * inlet.width * inlet.tangent +
                         (inlet.piston + 0.5 * inlet.spacing) * inlet.normal;
        p.add(x, inlet.speed * inlet.normal, density_ * volume, 1.0, volume,
              count > 0.0 ? pressure / count : -weight_.dot(x - origin_));
        ++state_.counts.born;
        inlet.net += volume;
      }
    }
    if (inlet.piston > -inlet.spacing) continue;
    std::vector<std::pair<double, std::size_t>> nearest;
    for (std::size_t a = 0; a < p.size(); ++a)
      if (const double depth = inlet.depth(p.position[a]);
          p.mask[a] <= 0.5 && inlet.before(p.position[a]) && depth < 2.0 * inlet.spacing)
        nearest.emplace_back(depth, a);
    std::sort(nearest.begin(), nearest.end());
    nearest.resize(std::min(nearest.size(), static_cast<std::size_t>(inlet.row)));
    std::vector<bool> keep(p.size(), true);
    for (const auto& [depth, a] : nearest) {
      keep[a] = false;
      const double volume = p.mass[a] / density_;
      inlet.net -= volume;
      inlet.piston += volume / inlet.width;
      ++state_.counts.deleted;
    }
    p.filter(keep);
  }
  place_pistons();
}

#define PORETWIN_INSTANTIATE(D)                                                                                   \
  template std::vector<Inlet<D>> make_inlets<D>(const Case&, const WaterBoundaries&);                             \
  template double inlet_speed<D>(const WaterBoundary&, const FaceState&, const Inlet<D>&, double, double, double, \
                                 double);                                                                         \
  template std::vector<sph::ImagePlane<D>> water_planes<D>(const Case&, const std::vector<Inlet<D>>&, double);    \
  template sph::Sight<D> water_sight<D>(const Case&, double);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE
template class Fluid<2>;
template class Fluid<3>;

}  // namespace poretwin::fluid
