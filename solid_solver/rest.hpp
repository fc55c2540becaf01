// The rest of the soil under its weight, the water's pressure and the standing loads, before time zero.
#pragma once

#include "solid_solver/step.hpp"

namespace poretwin::solid {

struct RestReport {
  std::size_t steps = 0;
  double residual = 0.0;   ///< largest acceleration (without damping) over the reference acceleration
  double criterion = 0.0;  ///< the rest is found when the residual is below it; zero: it was not sought
  [[nodiscard]] bool reached() const { return residual < criterion; }
};

/// Loads the soil in one increment and damps it near the critical rate of its slowest mode, pi c / H (xi about 3.6
/// h/H), until the largest acceleration is below 1e-3 of the driving one (gravity, or the largest external force).
/// Displacements and stresses stay; velocities are cleared. external(drive) fills its forces, anew after every rebuild.
template <int D, class ExternalForce>
RestReport find_rest(const Setup<D>& setup, State<D>& state, ExternalForce&& external) {
  RestReport report;
  Particles<D>& p = state.particles;
  const std::size_t n = p.free();
  Drive<D> drive;
  external(drive);
  auto acceleration = [&](std::size_t i) {
    Vec<D> force = drive.distributed[i];
    if (!drive.traction.empty()) force += drive.traction[i];
    return Vec<D>(force / p.mass[i]);
  };
  double reference = setup.gravity.norm();
  for (std::size_t i = 0; i < n; ++i)
    reference = std::max(reference, acceleration(i).norm() * setup.spacing / setup.height);
  report.criterion = 1e-3;
  if (reference <= 0.0) return report;
  const double speed = setup.stabilisers.sound_speed;
  drive.damping = 3.14159265358979 * speed / setup.height;
  const double dt = setup.longest_substep;
  const auto limit = static_cast<std::size_t>(50.0 * setup.height / (speed * dt)) + 200;
  while (report.steps < limit) {
    const double built = state.rebuilds;
    substep<D>(setup, dt, drive, state);
    ++report.steps;
    if (state.rebuilds > built) external(drive);
    if (report.steps % 10 != 0) continue;
    double largest = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const Vec<D> a = p.volume[i] / p.mass[i] * state.internal[i] + acceleration(i) + setup.gravity;
      largest = std::max({largest, a.norm(), drive.damping * p.velocity[i].norm()});
    }
    report.residual = largest / reference;
    check_finite(state, state.time);
    if (report.reached()) break;
  }
  for (auto& v : p.velocity) v.setZero();
  for (auto& gradient : p.gradient) gradient.setZero();
  evaluate_forces(setup, state);
  return report;
}

}  // namespace poretwin::solid
