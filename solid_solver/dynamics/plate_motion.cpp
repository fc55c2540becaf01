#include "solid_solver/dynamics/plate_motion.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin::solid {

template <int D>
void drive_plates(const Setup<D>& setup, double dt, const Drive<D>& drive, State<D>& state) {
  for (std::size_t k = 0; k < setup.plates.size(); ++k) {
    const PlateSetup<D>& plate = setup.plates[k];
    PlateMotion<D>& motion = state.particles.plates[k];
    const double across = plate.normal.dot(motion.velocity);
    motion.velocity.setZero();
    if (drive.plates.empty()) continue;
    Vec<D> way = drive.plates[k].target - motion.displacement;
    if (plate.is_free()) way -= plate.normal.dot(way) * plate.normal;
    motion.velocity = way / dt;
    if (!plate.is_free()) continue;
    // Damped motion is a search for rest, in which the mass does not matter: that of a row settles with the soil.
    const double mass = drive.damping > 0.0 ? plate.row : plate.mass;
    const double pushed = across + dt / mass * unbalanced(setup, state, drive, k);
    motion.velocity += pushed / (1.0 + dt * drive.damping) * plate.normal;
  }
}

namespace {

/// Force [N] of the pore pressure on a plate, in the direction against the plate's normal.
template <int D>
double water_on(const Setup<D>& setup, const State<D>& state, const PlatePairs& list, const Kernels& kernel) {
  const Particles<D>& p = state.particles;
  const std::size_t n = p.size();
  const Vec<D>& normal = setup.plates[list.plate].normal;
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
    force -= p.volume[i] * state.nodes[j].volume * static_cast<double>(kernel[m]) * normal.dot(weights * r);
  });
  return force;
}

}  // namespace

template <int D>
void measure_reactions(const Setup<D>& setup, State<D>& state) {
  const Particles<D>& p = state.particles;
  if (setup.plates.empty()) return;
  for (auto& plate : state.particles.plates) {
    plate.reaction.setZero();
    plate.water = 0.0;
  }
  Kernels kernel;
  std::vector<Force<D>> force(p.size());
  for (const PlatePairs& list : state.near.plate_pairs) {
    internal_force<D>(state.nodes, list.pairs, state.near.images, p.displacement, p.free(), setup.smoothing_length,
                      setup.stabilisers, kernel, force);
    Vec<D> sum = Vec<D>::Zero();
    for (std::size_t i = 0; i < p.free(); ++i) sum += p.volume[i] * (force[i].internal() + force[i].stabilising());
    const Vec<D>& normal = setup.plates[list.plate].normal;
    PlateMotion<D>& motion = state.particles.plates[list.plate];
    motion.reaction -= list.corner ? Vec<D>(normal.dot(sum) * normal) : sum;
    if (state.external.pressure.is_allocated()) motion.water += water_on(setup, state, list, kernel);
  }
}

template <int D>
void count_pulls(const Setup<D>& setup, State<D>& state) {
  for (std::size_t k = 0; k < setup.plates.size(); ++k) {
    PlateMotion<D>& plate = state.particles.plates[k];
    const double pressed = plate.water - setup.plates[k].normal.dot(plate.reaction);
    plate.largest = std::max(plate.largest, std::abs(pressed));
    plate.pull = std::max(plate.pull, -pressed);
    if (pressed < 0.0) plate.pulls += 1.0;
  }
}

template void count_pulls<2>(const Setup<2>&, State<2>&);
template void count_pulls<3>(const Setup<3>&, State<3>&);
template void drive_plates<2>(const Setup<2>&, double, const Drive<2>&, State<2>&);
template void drive_plates<3>(const Setup<3>&, double, const Drive<3>&, State<3>&);
template void measure_reactions<2>(const Setup<2>&, State<2>&);
template void measure_reactions<3>(const Setup<3>&, State<3>&);

}  // namespace poretwin::solid
