#include "solid_solver/dynamics/plate_motion.hpp"

#include "solid_solver/numerics/walls.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace poretwin::solid {

template <int D>
void drive_plates(const Setup<D>& setup, double dt, const Drive<D>& drive, State<D>& state) {
  for (std::size_t k = 0; k < setup.plates.size(); ++k) {
    const PlateSetup<D>& plate = setup.plates[k];
    PlateMotion<D>& motion = state.particles.plates[k];
    const double across = plate.normal.dot(motion.velocity);
    motion.velocity.setZero();
    if (drive.plates.empty()) {
      motion.spin = 0.0;
      continue;
    }
    Vec<D> way = drive.plates[k].target - motion.displacement;
    if (plate.is_free()) way -= plate.normal.dot(way) * plate.normal;
    motion.velocity = way / dt;
    if (!plate.is_free()) continue;
    // Damped motion is a search for rest, in which the mass does not matter: that of a row settles with the soil.
    const double mass = drive.damping > 0.0 ? plate.row : plate.mass;
    const double pushed = across + dt / mass * unbalanced(setup, state, drive, k);
    motion.velocity += pushed / (1.0 + dt * drive.damping) * plate.normal;
    if (!plate.tilts) continue;
    const double inertia = drive.damping > 0.0 ? plate.row_inertia : plate.inertia;
    const double turned = motion.spin + dt / inertia * unbalanced_moment(setup, state, drive, k);
    motion.spin = turned / (1.0 + dt * drive.damping);
  }
}

namespace {

/// Number of parts, about a spacing long, by which contact and pull of plate k are judged.
template <int D>
std::size_t parts_of(const Setup<D>& setup, std::size_t k) {
  return std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(2.0 * setup.plates[k].half / setup.spacing)));
}

/// A plate as the soil sees it now.
template <int D>
struct Placed {
  Vec<D> normal, along, middle;
  double half;
  Placed(const PlateSetup<D>& plate, const PlateMotion<D>& motion)
      : normal(rotation<D>(motion.angle) * plate.normal),
        along(rotation<D>(motion.angle) * plate.along),
        middle(plate.middle + motion.displacement),
        half(plate.half) {}
  /// Which of n parts of the plate lies before x.
  [[nodiscard]] std::size_t part(std::size_t n, const Vec<D>& x) const {
    return part_at(n, 2.0 * half, along.dot(x - middle) + half);
  }
};

/// Adds the force of the pore pressure on the soil, along the plate's normal, and its moment about the plate's middle.
template <int D>
void add_water(const Setup<D>& setup, const PlatePairs& list, const Kernels& kernel, const Placed<D>& placed,
               State<D>& state) {
  const Particles<D>& p = state.particles;
  const std::size_t n = p.size();
  const Vec<D>& normal = placed.normal;
  const bool tilts = setup.plates[list.plate].tilts;
  PlateMotion<D>& motion = state.particles.plates[list.plate];
  const auto at_plate = [&](std::size_t i, double distance) {
    return state.external.pressure[i] - distance * normal.dot(state.external.pressure_gradient[i]);
  };
  double force = 0.0;
  for_each_pair(list.pairs, [&](std::size_t i, std::size_t j, std::size_t m, bool) {
    if (i >= p.free()) return;
    const Vec<D> r = state.nodes[i].position - state.nodes[j].position;
    const std::size_t parent = state.near.images[j - n].parent;
    const double apart = normal.dot(r);  // sum of both distances from the plate, also for a corner's image
    const double own = normal.dot(state.nodes[i].position - state.nodes[parent].position);
    const double pressure_i = at_plate(i, 0.5 * (apart + own)), pressure_j = at_plate(parent, 0.5 * (apart - own));
    const Mat<D> weights = pressure_i * state.nodes[i].correction() + pressure_j * correction_at(state, j);
    const double share = p.volume[i] * state.nodes[j].volume * static_cast<double>(kernel[m]) * normal.dot(weights * r);
    force -= share;
    if (!tilts) return;
    const Vec<D> place = 0.5 * (state.nodes[i].position + state.nodes[j].position);
    motion.water_moment -= share * placed.along.dot(place - placed.middle);
    motion.pressed[placed.part(motion.pressed.size(), place)] -= share;
  });
  motion.water += force;
}

/// Adds the moment of the skeleton on a plate that tilts, and the forces of its parts. force: of the plate's images on
/// the particles, per volume.
template <int D>
void add_moment(const PlatePairs& list, const Kernels& kernel, const Placed<D>& placed, std::span<const Force<D>> force,
                State<D>& state) {
  const Particles<D>& p = state.particles;
  PlateMotion<D>& motion = state.particles.plates[list.plate];
  const auto borne = [&](const Vec<D>& f) {
    return list.bears_all() ? f : Vec<D>(placed.normal.dot(f) * placed.normal);
  };
  for (std::size_t i = 0; i < p.free(); ++i) {
    const Vec<D> f = p.volume[i] * borne(force[i].internal() + force[i].stabilising());
    motion.moment -= moment_of<D>(p.position[i] - placed.middle, f);
    motion.pressed[placed.part(motion.pressed.size(), p.position[i])] += placed.normal.dot(f);
  }
  for_each_pair(list.pairs, [&](std::size_t i, std::size_t j, std::size_t m, bool) {
    if (i >= p.free()) return;
    const Node<D>&own = state.nodes[i], &image = state.nodes[j];
    const Vec<D> r = own.position - image.position;
    const Vec<D> f = p.volume[i] * image.volume * static_cast<double>(kernel[m]) * (own.flux * r);
    motion.moment += moment_of<D>(r, borne(f));
  });
}

}  // namespace

template <int D>
void measure_reactions(const Setup<D>& setup, State<D>& state) {
  const Particles<D>& p = state.particles;
  if (setup.plates.empty()) return;
  for (std::size_t k = 0; k < setup.plates.size(); ++k) {
    PlateMotion<D>& motion = state.particles.plates[k];
    motion.reaction.setZero();
    motion.water = motion.moment = motion.water_moment = 0.0;
    if (setup.plates[k].tilts) motion.pressed.assign(parts_of(setup, k), 0.0);
  }
  Kernels kernel;
  std::vector<Force<D>> force(p.size());
  for (const PlatePairs& list : state.near.plate_pairs) {
    internal_force<D>(state.nodes, list.pairs, state.near.images, p.displacement, p.free(), setup.smoothing_length,
                      setup.stabilisers, kernel, force);
    Vec<D> sum = Vec<D>::Zero();
    for (std::size_t i = 0; i < p.free(); ++i) sum += p.volume[i] * (force[i].internal() + force[i].stabilising());
    PlateMotion<D>& motion = state.particles.plates[list.plate];
    const Placed<D> placed(setup.plates[list.plate], motion);
    const Vec<D> across = placed.normal.dot(sum) * placed.normal;
    motion.reaction -= across;
    for (const int bearer : list.along)
      if (bearer >= 0) state.particles.plates[static_cast<std::size_t>(bearer)].reaction -= 0.5 * (sum - across);
    if (setup.plates[list.plate].tilts) add_moment<D>(list, kernel, placed, force, state);
    if (state.external.pressure.is_allocated()) add_water<D>(setup, list, kernel, placed, state);
  }
}

template <int D>
void count_pulls(const Setup<D>& setup, State<D>& state) {
  for (std::size_t k = 0; k < setup.plates.size(); ++k) {
    if (setup.plates[k].lifts) continue;  // it comes off
    PlateMotion<D>& plate = state.particles.plates[k];
    double pressed = 0.0, pull = 0.0;
    if (setup.plates[k].tilts) {
      for (const double part : plate.pressed) (part < 0.0 ? pull : pressed) += std::abs(part);
    } else {
      pressed = pressing(setup, state, k);
      pull = -pressed;
    }
    plate.largest = std::max({plate.largest, std::abs(pressed), pull});
    plate.pull = std::max(plate.pull, pull);
    if (pull > 0.0) plate.pulls += 1.0;
  }
}

template <int D>
bool update_contacts(const Setup<D>& setup, State<D>& state) {
  bool changed = false;
  for (std::size_t k = 0; k < setup.plates.size(); ++k) {
    if (!setup.plates[k].lifts) continue;
    PlateMotion<D>& motion = state.particles.plates[k];
    const std::size_t n = motion.pressed.size();
    motion.apart.resize(n, 0);
    motion.touched_at.resize(n, 0.0);
    const Placed<D> placed(setup.plates[k], motion);
    ScalarArray nearest(n, std::numeric_limits<double>::infinity());
    for (const BehindPlate<D>& behind : state.near.behind_plates) {
      if (behind.plate != k) continue;
      const Vec<D>& x = state.particles.position[state.near.images[behind.image].parent];
      double& distance = nearest[placed.part(n, x)];
      distance = std::min(distance, placed.normal.dot(x - placed.middle));
    }
    double all = 0.0;
    for (const double part : motion.pressed) all += std::abs(part);
    for (std::size_t a = 0; a < n; ++a) {
      const bool pulls = motion.pressed[a] < -walls::comes_off_above * all;
      if (motion.apart[a] ? nearest[a] > motion.touched_at[a] : !pulls) continue;
      motion.apart[a] = motion.apart[a] ? 0 : 1;
      motion.touched_at[a] = nearest[a];
      changed = true;
    }
  }
  return changed;
}

template bool update_contacts<2>(const Setup<2>&, State<2>&);
template bool update_contacts<3>(const Setup<3>&, State<3>&);
template void count_pulls<2>(const Setup<2>&, State<2>&);
template void count_pulls<3>(const Setup<3>&, State<3>&);
template void drive_plates<2>(const Setup<2>&, double, const Drive<2>&, State<2>&);
template void drive_plates<3>(const Setup<3>&, double, const Drive<3>&, State<3>&);
template void measure_reactions<2>(const Setup<2>&, State<2>&);
template void measure_reactions<3>(const Setup<3>&, State<3>&);

}  // namespace poretwin::solid
