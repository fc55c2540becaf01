// Soil that hardly moves: its departure from rest, the damping towards rest, and sleep.
#pragma once

#include "solid_solver/dynamics/plate_motion.hpp"
#include "solid_solver/numerics/sleep.hpp"

#include <numbers>
#include <span>

namespace poretwin::solid {

/// Largest and root-mean-square departure from rest [1]. The departure of a particle is its unbalanced acceleration or,
/// where larger, its velocity times the near-critical damping rate, over a reference acceleration.
struct Unrest {
  double largest = 0.0, rms = 0.0;
  double share = 0.0;  ///< fraction of the mass whose departure exceeds `sleep::restless`
};

/// Damping rate [1/s] that is critical for the slowest mode of a column of the soil's height: 2 omega = pi c / H.
template <int D>
double near_critical_damping(const Setup<D>& setup) {
  return std::numbers::pi * setup.stabilisers.sound_speed / setup.height;
}

/// Force from outside on particle i [N], without its weight.
template <int D>
Vec<D> force_from_outside(const Drive<D>& drive, std::size_t i) {
  return drive.traction.empty() ? drive.distributed[i] : Vec<D>(drive.distributed[i] + drive.traction[i]);
}

/// Force on every free particle [N], without hourglass control.
template <int D>
VecArray<D> forces(const Setup<D>& setup, const State<D>& state, const Drive<D>& drive) {
  const Particles<D>& p = state.particles;
  VecArray<D> force(p.free());
  for (std::size_t i = 0; i < p.free(); ++i)
    force[i] = p.volume[i] * state.force[i].internal() + force_from_outside(drive, i) + p.mass[i] * setup.gravity;
  return force;
}

/// Reference acceleration [m/s2]: gravity or, where larger, the forces per mass from outside and from plates,
/// distributed over the soil's height.
template <int D>
double reference_acceleration(const Setup<D>& setup, const State<D>& state, const Drive<D>& drive) {
  double reference = setup.gravity.norm();
  for (std::size_t i = 0; i < state.particles.free(); ++i)
    reference = std::max(reference,
                         force_from_outside(drive, i).norm() / state.particles.mass[i] * setup.spacing / setup.height);
  for (std::size_t k = 0; k < setup.plates.size(); ++k) {
    double pressed = std::max(drive.plates.empty() ? 0.0 : std::abs(drive.plates[k].force),
                              state.particles.plates[k].reaction.norm());
    if (setup.plates[k].tilts && !drive.plates.empty())
      pressed = std::max(pressed, std::abs(drive.plates[k].moment) / setup.plates[k].half);
    reference = std::max(reference, pressed / setup.plates[k].row * setup.spacing / setup.height);
    if (drive.plates.empty() || setup.plates[k].is_free()) continue;
    // The stress that the remaining displacement to the target causes in a column of the soil's height.
    const double way = (drive.plates[k].target - state.particles.plates[k].displacement).norm();
    const double speed = setup.stabilisers.sound_speed / setup.height;
    reference = std::max(reference, speed * speed * way);
  }
  return setup.domain.max(reference);
}

/// Fraction of the mass that belongs to free particles i for which moves(i) holds.
template <int D, class Moves>
double share_of_mass(const Domain& domain, const Particles<D>& p, Moves&& moves) {
  double share = 0.0, whole = 0.0;
  for (std::size_t i = 0; i < p.free(); ++i) {
    whole += p.mass[i];
    if (moves(i)) share += p.mass[i];
  }
  return domain.sum(share) / domain.sum(whole);
}

template <int D>
Unrest unrest(const Setup<D>& setup, const State<D>& state, std::span<const Vec<D>> force, double reference) {
  const Particles<D>& p = state.particles;
  const double rate = near_critical_damping(setup);
  Unrest result;
  if (reference <= 0.0) return result;
  const double count = setup.domain.sum(static_cast<double>(p.free()));
  result.share = share_of_mass(setup.domain, p, [&](std::size_t i) {
    const double departure = std::max(force[i].norm() / p.mass[i], rate * p.velocity[i].norm()) / reference;
    result.largest = std::max(result.largest, departure);
    result.rms += departure * departure / count;
    return departure > sleep::restless;
  });
  result.largest = setup.domain.max(result.largest);
  result.rms = std::sqrt(setup.domain.sum(result.rms));
  return result;
}

template <int D>
Unrest unrest(const Setup<D>& setup, const State<D>& state, const Drive<D>& drive, double reference) {
  const VecArray<D> force = forces(setup, state, drive);
  return unrest<D>(setup, state, std::span<const Vec<D>>(force), reference);
}

/// Sets all velocities to zero.
template <int D>
void stop(const Setup<D>& setup, State<D>& state) {
  for (auto& v : state.particles.velocity) v.setZero();
  for (auto& s : state.particles.slip) s.setZero();
  for (auto& plate : state.particles.plates) {
    plate.velocity.setZero();
    plate.spin = 0.0;
  }
  for (auto& node : state.nodes) node.gradient.setZero();
  evaluate_forces(setup, state);
}

/// Whether the degree of saturation has changed by more than `sleep::softening` since the soil was last found at rest,
/// in soil whose cohesion depends on saturation.
template <int D>
bool softened(const Setup<D>& setup, const State<D>& state) {
  const auto& now = state.external.saturation;
  const auto& before = state.sleep.saturation;
  bool any = false;
  for (std::size_t i = 0; i < state.particles.free() && !any; ++i)
    any = setup.softened_by_water[state.particles.material[i]] &&
          (!before.is_allocated() || std::abs(now[i] - before[i]) > sleep::softening);
  return setup.domain.any(any);
}

/// Least length [s] of a long window, which is computed as an equilibrium. It is the time in which elastic waves cross
/// the soil and return.
template <int D>
double long_window(const Setup<D>& setup) {
  return 2.0 * setup.height / setup.stabilisers.sound_speed;
}

/// Whether something disturbs the sleeping soil. Since it fell asleep, either the water's force on a particle has
/// changed by more than `wake_above` times the reference acceleration, or water has softened the soil, or a load has
/// begun. loads: number of loads that have begun.
template <int D>
bool disturbed(const Setup<D>& setup, const State<D>& state, const Drive<D>& drive, std::size_t loads, double reference,
               double wake_above) {
  if (loads != state.sleep.loads || softened(setup, state)) return true;
  bool any = false;
  for (std::size_t i = 0; i < state.particles.free() && !any; ++i) {
    const double change = (drive.distributed[i] - state.sleep.force[i]).norm();
    any = change > wake_above * reference * state.particles.mass[i];
  }
  return setup.domain.any(any);
}

}  // namespace poretwin::solid
