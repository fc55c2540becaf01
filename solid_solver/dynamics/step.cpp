#include "solid_solver/dynamics/step.hpp"

#include "common/core/error.hpp"
#include "common/core/threads.hpp"
#include "solid_solver/discretisation/lists_hold.hpp"
#include "solid_solver/discretisation/ranks.hpp"
#include "solid_solver/dynamics/flow_regularisation.hpp"
#include "solid_solver/dynamics/plate_motion.hpp"
#include "solid_solver/dynamics/straining.hpp"
#include "solid_solver/dynamics/wall_friction.hpp"
#include "solid_solver/numerics/walls.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace poretwin::solid {

template <int D>
void evaluate_kernels(const Setup<D>& setup, State<D>& state) {
  fill_nodes(setup, state);
  pair_kernels<D>(state.nodes, state.near.pairs, setup.smoothing_length, 0, state.kernel);
}

template <int D>
void rebuild_lists(const Setup<D>& setup, State<D>& state) {
  Particles<D>& p = state.particles;
  wrap_periodic<D>(setup.boundaries, p.position);
  Boundaries<D> moved;  // with the plates at their present places
  if (!setup.plates.empty()) moved = with_plates_at<D>(p.plates, setup.boundaries);
  const Boundaries<D>& boundaries = setup.plates.empty() ? setup.boundaries : moved;
  keep_before_walls<D>(boundaries, setup.spacing, state.near, p);
  share_out(setup, state);
  build_neighbourhood<D>(boundaries, setup.range(), setup.parts, p, state.regions.asleep, state.near);
  refit_deformation<D>(p, state.near, setup.smoothing_length, state.nodes);
  state.rebuilds += 1.0;
  if (setup.domain.any(!state.near.pairs.skipped.empty())) evaluate_kernels(setup, state);
}

template <int D>
void rebuild(const Setup<D>& setup, State<D>& state) {
  rebuild_lists(setup, state);
  evaluate_kernels(setup, state);
  velocity_gradient<D>(state.near.pairs, state.kernel, state.nodes);
}

template <int D>
bool rebuild_if_moved(const Setup<D>& setup, State<D>& state) {
  if (setup.domain.all(lists_hold(setup, state.particles, state.near))) return false;
  rebuild_lists(setup, state);
  return true;
}

template <int D>
void evaluate_forces(const Setup<D>& setup, State<D>& state) {
  const std::size_t n_free = state.particles.free();
  fill_nodes(setup, state);
  internal_force<D>(state.nodes, state.near, state.particles.displacement, n_free, setup.smoothing_length,
                    setup.stabilisers, state.kernel, state.force);
  pair_kernels<D>(state.nodes, state.near.pairs, setup.smoothing_length, n_free, state.kernel);
  pull_back<D>(state.nodes, state.near, state.kernel, state.particles.slip, state.force);
  if (setup.stabilisers.artificial_stress > 0.0) {
    VecArray<D> repelling(n_free, Vec<D>::Zero());
    add_artificial_stress<D>(state, setup.stabilisers.artificial_stress, setup.spacing, setup.smoothing_length,
                             repelling);
    for (std::size_t i = 0; i < n_free; ++i) state.force[i].add_stabilising(repelling[i]);
  }
  measure_reactions(setup, state);
}

template <int D>
Vec<D> force_from_outside(const Setup<D>& setup, const State<D>& state, const Drive<D>& drive) {
  const Particles<D>& p = state.particles;
  Vec<D> sum = Vec<D>::Zero();
  for (std::size_t i = 0; i < p.free(); ++i) {
    sum += p.volume[i] * (state.force[i].internal() + state.force[i].stabilising()) + p.mass[i] * setup.gravity;
    if (!drive.traction.empty()) sum += drive.traction[i];
  }
  return sum;
}

template <int D>
void substep(const Setup<D>& setup, double dt, const Drive<D>& drive, State<D>& state) {
  Particles<D>& p = state.particles;
  if (setup.counts_impulses) state.from_outside += dt * force_from_outside(setup, state, drive);
  for_rows(state.near.pairs, 0, p.free(), [&](std::size_t i) {
    if (state.regions.sleeps(i)) {
      // A sleeping particle transmits waves: a force from its neighbours moves it as fast as a wave would, until the
      // force counts as a disturbance.
      const Vec<D> push = p.volume[i] * state.force[i].internal() - state.regions.mark[i];
      const double let_through = 0.5 * setup.stabilisers.sound_speed / setup.spacing;
      p.velocity[i] = (p.velocity[i] + dt / p.mass[i] * push) / (1.0 + dt * let_through);
      return;
    }
    Vec<D> force = p.volume[i] * (state.force[i].internal() + state.force[i].stabilising()) + p.mass[i] * setup.gravity;
    force += drive.distributed[i];
    if (!drive.traction.empty()) force += drive.traction[i];
    state.body[i] = (p.mass[i] * setup.gravity + drive.distributed[i]) / p.volume[i];
    const double rate = dt / p.mass[i], damping = drive.damping_at(state, i);
    if (drive.tracking.empty()) {
      p.velocity[i] = (p.velocity[i] + rate * force) / (1.0 + dt * damping);
      return;
    }
    const double z = drive.tracking[i];
    p.velocity[i] = (p.velocity[i] + rate * (force + z * drive.target[i])) / (1.0 + rate * z + dt * damping);
    state.returned_impulse.values()[i] += dt * z * (drive.target[i] - p.velocity[i]);
  });
  drive_plates(setup, dt, drive, state);
  rub_on_walls(setup, dt, state);
  deform(setup, dt, &drive, state);
  keep_flow_regular(setup, dt, false, state);
  rebuild_if_moved(setup, state);
  evaluate_forces(setup, state);
  if (update_contacts(setup, state)) {
    rebuild_lists(setup, state);
    evaluate_forces(setup, state);
  }
}

template <int D>
void deform(const Setup<D>& setup, double dt, const Drive<D>* drive, State<D>& state) {
  Particles<D>& p = state.particles;
  const Pairs& pairs = state.near.pairs;
  fill_velocities(setup, state);
  velocity_gradient<D>(pairs, state.kernel, state.nodes);
  for_rows(pairs, 0, p.free(), [&](std::size_t i) {
    if (state.regions.sleeps(i)) {
      state.nodes[i].gradient.setZero();
      return;
    }
    const Vec<D> moved = dt * p.velocity[i];
    p.position[i] += moved;
    p.displacement[i] += moved;
    if (state.dilation.is_allocated()) state.dilation.values()[i] += dt * state.nodes[i].gradient.trace();
    // The gradient of the displacement with respect to the present position, at a moving particle: d(1 - F^-1)/dt =
    // F^-1 L, with the deformation gradient F and the velocity gradient L.
    Node<D>& node = state.nodes[i];
    node.deformation += dt * (node.gradient - node.deformation * node.gradient);
  });
  for (auto& plate : p.plates) {
    plate.displacement += dt * plate.velocity;
    plate.angle += dt * plate.spin;
  }
  strain<D>(setup, dt, drive && drive->timeless ? std::numeric_limits<double>::infinity() : dt, state);
  slide_on_walls(setup, dt, drive, state);
  state.any_yielded = state.any_yielded || setup.domain.any(std::any_of(state.yielded.begin(), state.yielded.end(),
                                                                        [](char y) { return y; }));
}

template <int D>
VecArray<D> pressure_gradient(const State<D>& state, SolidCase::PressureGradient form, const Vec<D>& water_weight,
                              std::span<const double> pressure) {
  if (form == SolidCase::PressureGradient::sum) return pressure_gradient_sum<D>(state, pressure, water_weight);
  if (std::all_of(pressure.begin(), pressure.end(), [](double p) { return p == 0.0; }))
    return VecArray<D>(pressure.size(), Vec<D>::Zero());  // dry
  return pressure_gradient_difference<D>(state, pressure);
}

template <int D>
void measure_loads(const State<D>& state, Setup<D>& setup) {
  VecArray<D> q;
  std::map<std::size_t, double> measured;  // length of each load, measured on the lattice [m]
  for (const auto& patch : setup.loads) {
    if (patch.length <= 0.0) continue;
    if (q.empty()) q = surface_vectors<D>(state);
    double& length = measured[patch.load];
    for_each_own<D>(state.particles, patch.particles,
                    [&](Index i) { length += state.particles.volume[i] * patch.normal.dot(q[i]); });
  }
  for (auto& [load, length] : measured) length = setup.domain.sum(length);
  for (auto& patch : setup.loads)
    if (const auto found = measured.find(patch.load); found != measured.end() && found->second != 0.0)
      patch.scale = patch.length / found->second;
}

template <int D>
VecArray<D> load_forces(const Setup<D>& setup, const State<D>& state, double time) {
  VecArray<D> force(state.particles.size(), Vec<D>::Zero());
  VecArray<D> q;
  std::vector<char> at_surface;  // empty: all
  for (const auto& patch : setup.loads) {
    if (time < patch.start) continue;
    if (q.empty()) q = surface_vectors<D>(state);
    // Only where the water's pressure has the adjoint form, too: water that bears the load then balances it exactly.
    const bool sparing = setup.water.is_field && patch.normal.isZero();
    if (sparing && at_surface.empty()) at_surface = feel_surface<D>(setup.spacing, state, q);
    const double factor = patch.scale * (patch.factor ? patch.factor->at(time) : 1.0);
    const Vec<D> traction = factor * patch.traction;
    // A pressure on all sides is the force of a uniform stress: its work is the pressure times the change of volume,
    // whatever the shape of the surface and the arrangement of the particles.
    for_each_own<D>(state.particles, patch.particles, [&](Index i) {
      if (sparing && !at_surface[i]) return;
      const Vec<D> area = state.particles.volume[i] * q[i];
      force[i] += patch.normal.dot(area) * traction + (factor * patch.pressure) * area;
    });
  }
  return force;
}

template <int D>
void check_sound(const Setup<D>& setup, const State<D>& state, double last_good_time) {
  const double fastest = setup.spacing / setup.longest_substep;
  const auto& p = state.particles;
  for (std::size_t k = 0; k < setup.plates.size(); ++k) {
    const PlateSetup<D>& plate = setup.plates[k];
    const double turned = plate.tilts ? plate.half * std::abs(std::sin(p.plates[k].angle)) : 0.0;
    const double sunk = plate.normal.dot(p.plates[k].displacement) + turned;  // of its lower end
    if (plate.sinks_in && !(sunk <= walls::deepest_plate * setup.spacing))
      throw DivergedError(fmt::format(
          "plate \"{}\" has sunk by {:.4g} m into soil that lies beside its ends: farther than {:g} spacings "
          "soil may flow over it, which is not computed; last good time {:.6g} s",
          plate.name, sunk, walls::deepest_plate, last_good_time));
  }
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double sum = p.velocity[i].sum() + p.position[i].sum() + p.stress[i].sum() + p.volume[i];
    if (std::isfinite(sum) && p.volume[i] > 0.0 && p.velocity[i].norm() <= fastest) continue;
    const Tensor& s = p.stress[i];
    throw DivergedError(
        fmt::format("the soil diverged at particle {} near ({}): velocity ({}) m/s, volume {:.4g}, stress xx {:.4g} yy "
                    "{:.4g} zz {:.4g} "
                    "xy {:.4g} Pa; last good time {:.6g} s",
                    i, fmt::join(state.near.built_at[i].data(), state.near.built_at[i].data() + D, ", "),
                    fmt::join(p.velocity[i].data(), p.velocity[i].data() + D, ", "), p.volume[i], s[0], s[1], s[2],
                    s[3], last_good_time));
  }
}

#define PORETWIN_INSTANTIATE(D)                                                                          \
  template void evaluate_kernels<D>(const Setup<D>&, State<D>&);                                         \
  template void rebuild_lists<D>(const Setup<D>&, State<D>&);                                            \
  template void rebuild<D>(const Setup<D>&, State<D>&);                                                  \
  template bool rebuild_if_moved<D>(const Setup<D>&, State<D>&);                                         \
  template void evaluate_forces<D>(const Setup<D>&, State<D>&);                                          \
  template Vec<D> force_from_outside<D>(const Setup<D>&, const State<D>&, const Drive<D>&);              \
  template void substep<D>(const Setup<D>&, double, const Drive<D>&, State<D>&);                         \
  template void deform<D>(const Setup<D>&, double, const Drive<D>*, State<D>&);                          \
  template VecArray<D> pressure_gradient<D>(const State<D>&, SolidCase::PressureGradient, const Vec<D>&, \
                                            std::span<const double>);                                    \
  template void measure_loads<D>(const State<D>&, Setup<D>&);                                            \
  template VecArray<D> load_forces<D>(const Setup<D>&, const State<D>&, double);                         \
  template void check_sound<D>(const Setup<D>&, const State<D>&, double);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::solid
