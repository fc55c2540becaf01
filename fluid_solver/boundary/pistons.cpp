#include "fluid_solver/boundary/pistons.hpp"

#include "common/core/error.hpp"
#include "fluid_solver/discretisation/bodies.hpp"
#include "fluid_solver/discretisation/ranks.hpp"
#include "fluid_solver/numerics/faces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace poretwin::fluid {

namespace {

/// Diagonal of the box around the body of water whose particle is nearest to x [m]; 0 where there is none. All ranks
/// call this.
template <int D>
double length_of_body(const Setup<D>& setup, const Particles<D>& p, const MeasuredBodies<D>& bodies, const Vec<D>& x) {
  double nearest = HUGE_VAL;
  std::size_t found = p.size();
  for (std::size_t a = 0; a < p.size(); ++a)
    if (const double distance = (p.position[a] - x).squaredNorm(); bodies.of[a] >= 0 && distance < nearest) {
      nearest = distance;
      found = a;
    }
  std::vector<std::array<double, 3>> length;  // distance of the particle, its id, length of its body
  if (found != p.size()) {
    const Extent<D>& of = bodies.extent[static_cast<std::size_t>(bodies.of[found])];
    length.push_back({nearest, static_cast<double>(id_of(p, found)), (of.upper - of.lower).norm()});
  }
  length = from_all_ranks(setup, std::move(length));
  return length.empty() ? 0.0 : length.front()[2];
}

}  // namespace

template <int D>
void set_inlets(const Setup<D>& setup, const Faces<D>& faces, const Walls<D>& walls, double time, double interval,
                State<D>& state) {
  if (state.inlets.empty()) return;
  const auto& p = state.particles;
  const double near = 4.0 * setup.spacing;
  const Vec<D> up = setup.weight.norm() > 0.0 ? Vec<D>(-setup.weight.normalized()) : Vec<D>(Vec<D>::Zero());
  std::vector<char> free(p.size());
  for (std::size_t a = 0; a < p.size(); ++a) free[a] = p.mask[a] <= 0.5 && p.surface[a] != Surface::lone;
  const auto bodies = measured_bodies<D>(setup, walls, p, free);
  raise_wave_speeds<D>(setup, bodies, state.particles);
  for (auto& inlet : state.inlets) {
    std::array<double, 6> sums{};
    auto& [level, surface, head, water, moving, speed] = sums;
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
    setup.domain.sum(sums);
    // A full pipe has no surface: the level then follows from the pressure.
    if (surface > 0.0)
      inlet.level = level / surface;
    else if (inlet.sill)
      inlet.level = inlet.lowest;
    else
      inlet.level = water > 0.0 ? head / (water * setup.weight.norm()) + up.dot(setup.origin) : inlet.lowest;
    if (inlet.sill) {
      const double over = faces.level(state, inlet.face, time).value() - inlet.lowest;
      // The speed is an average over time: water in front of a piston moves with it, so that its present speed would
      // only be that of the piston.
      const double averaging_time =
          faces::current_waves * near / std::sqrt(setup.gravity_or_standard * std::max(setup.spacing, over));
      inlet.current +=
          std::min(1.0, interval / averaging_time) * ((moving > 0.0 ? speed / moving : 0.0) - inlet.current);
      const auto flow =
          flow_over(over, {std::max(0.0, inlet.level - inlet.lowest), inlet.current}, setup.gravity_or_standard);
      inlet.flows = over > 0.0;
      inlet.speed = flow.speed;
      inlet.open(flow.depth, setup.spacing);
    } else {
      if (const auto wanted = faces.level(state, inlet.face, time); wanted) {
        // Water of length L and depth d responds to a discharge within L / sqrt(g d). The current is corrected over
        // four times that time, which avoids oscillation. The missing head is limited to one spacing, so that it causes
        // no large current in a reservoir that is being filled.
        const double wave = std::sqrt(setup.gravity_or_standard * std::max(setup.spacing, *wanted - inlet.lowest));
        const double missing = std::clamp(*wanted - inlet.level, -setup.spacing, setup.spacing);
        const double length = std::max(setup.spacing, length_of_body<D>(setup, p, bodies, inlet.foot));
        inlet.current += interval * wave * wave / (4.0 * length) * missing / inlet.width;
      }
      const auto f = static_cast<std::size_t>(inlet.face);
      inlet.speed =
          inlet_speed(*faces.boundaries[f], state.faces[f], inlet, setup.spacing, setup.gravity, time, interval);
      if (inlet.speed == 0.0) inlet.current = std::max(0.0, inlet.current);  // the opening cannot draw water at present
    }
    const double volume = inlet.speed * inlet.width * interval;
    (volume > 0.0 ? state.balance.in : state.balance.out) += std::abs(volume);
  }
}

template <int D>
void check_room(const Setup<D>& setup, const State<D>& state, double time) {
  const auto& p = state.particles;
  double inflow = 0.0;
  for (const auto& inlet : state.inlets) inflow += inlet.speed * inlet.width;
  if (inflow == 0.0 || std::any_of(state.columns.begin(), state.columns.end(), [](const auto& c) { return c.wet; }) ||
      !setup.domain.any(p.size() > 0) ||
      setup.domain.any_of(p.size(), [&](std::size_t a) { return p.surface[a] != Surface::interior; }))
    return;
  throw DivergedError(
      fmt::format("fluid: at t = {:.4g} s water fills all the room between the walls, and the inlets still ask for "
                  "{:.4g} m2/s; give "
                  "it an outlet, a free surface or less discharge",
                  time, inflow));
}

template <int D>
void serve_inlets(const Setup<D>& setup, State<D>& state) {
  if (state.inlets.empty()) return;
  auto& p = state.particles;
  for (auto& inlet : state.inlets) {
    while (inlet.piston >= 0.5 * inlet.spacing) {
      std::array<double, 2> sums{};
      auto& [pressure, count] = sums;
      for (std::size_t a = 0; a < p.size(); ++a)
        if (inlet.before(p.position[a]) && std::abs(inlet.depth(p.position[a])) < inlet.spacing) {
          pressure += p.pressure[a];
          count += 1.0;
        }
      setup.domain.sum(sums);
      inlet.piston -= inlet.spacing;
      const double volume = inlet.width * inlet.spacing / inlet.row;
      for (int i = 0; i < inlet.row; ++i) {
        const Vec<D> x = inlet.foot + ((i + 0.5) / inlet.row - 0.5) * inlet.width * inlet.tangent +
                         (inlet.piston + 0.5 * inlet.spacing) * inlet.normal;
        add_particle(setup, p, x, Vec<D>(inlet.speed * inlet.normal), setup.density * volume, 1.0, volume,
                     count > 0.0 ? pressure / count : -setup.weight.dot(x - setup.origin),
                     Provenance{std::sqrt(setup.gravity * setup.spacing), false});
        ++state.counts.born;
        inlet.net += volume;
      }
    }
    if (inlet.piston > -inlet.spacing) continue;
    std::vector<std::array<double, 3>> nearest;  // depth, id, mass
    for (std::size_t a = 0; a < p.size(); ++a)
      if (const double depth = inlet.depth(p.position[a]);
          p.mask[a] <= 0.5 && inlet.before(p.position[a]) && depth < 2.0 * inlet.spacing)
        nearest.push_back({depth, static_cast<double>(id_of(p, a)), p.mass[a]});
    nearest = from_all_ranks(setup, std::move(nearest));
    nearest.resize(std::min(nearest.size(), static_cast<std::size_t>(inlet.row)));
    std::set<GlobalId> gone;
    for (const auto& [depth, id, mass] : nearest) {
      gone.insert(static_cast<GlobalId>(id));
      const double volume = mass / setup.density;
      inlet.net -= volume;
      inlet.piston += volume / inlet.width;
      ++state.counts.deleted;
    }
    std::vector<bool> keep(p.size());
    for (std::size_t a = 0; a < p.size(); ++a) keep[a] = !gone.contains(id_of(p, a));
    p.filter(keep);
  }
}

#define PORETWIN_INSTANTIATE(D)                                                                           \
  template void set_inlets(const Setup<D>&, const Faces<D>&, const Walls<D>&, double, double, State<D>&); \
  template void check_room(const Setup<D>&, const State<D>&, double);                                     \
  template void serve_inlets(const Setup<D>&, State<D>&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::fluid
