#include "solid_solver/dynamics/plate_motion.hpp"

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
    // Damped motion is a search for rest, in which the mass does not count: a row's comes to rest with the soil.
    const double mass = drive.damping > 0.0 ? plate.row : plate.mass;
    const double pushed = across + dt / mass * unbalanced(setup, state, drive, k);
    motion.velocity += pushed / (1.0 + dt * drive.damping) * plate.normal;
  }
}

template <int D>
void measure_reactions(const Setup<D>& setup, State<D>& state) {
  const Particles<D>& p = state.particles;
  if (setup.plates.empty()) return;
  for (auto& plate : state.particles.plates) plate.reaction.setZero();
  Kernels kernel;
  std::vector<Force<D>> force(p.size());
  for (const PlatePairs& list : state.near.plate_pairs) {
    internal_force<D>(state.nodes, list.pairs, state.near.images, p.displacement, p.free(), setup.smoothing_length,
                      setup.stabilisers, kernel, force);
    Vec<D> sum = Vec<D>::Zero();
    for (std::size_t i = 0; i < p.free(); ++i) sum += p.volume[i] * (force[i].internal() + force[i].stabilising());
    const Vec<D>& normal = setup.plates[list.plate].normal;
    state.particles.plates[list.plate].reaction -= list.corner ? Vec<D>(normal.dot(sum) * normal) : sum;
  }
}

template void drive_plates<2>(const Setup<2>&, double, const Drive<2>&, State<2>&);
template void drive_plates<3>(const Setup<3>&, double, const Drive<3>&, State<3>&);
template void measure_reactions<2>(const Setup<2>&, State<2>&);
template void measure_reactions<3>(const Setup<3>&, State<3>&);

}  // namespace poretwin::solid
