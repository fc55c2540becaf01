// The rest of the soil under its weight, the water's pressure and the standing loads, before time zero.
#pragma once

#include "solid_solver/step.hpp"

namespace poretwin::solid {

struct RestReport {
  std::size_t steps = 0;
  double displacement = 0.0;  ///< m, largest
  double residual = 0.0;      ///< largest acceleration (without damping) over the reference acceleration
  double criterion = 0.0;     ///< the rest is found when the residual is below it; zero: it was not sought
  [[nodiscard]] bool reached() const { return residual < criterion; }
};

/// Rate that damps the present motion critically, 2 omega [1/s], with Rayleigh's quotient omega^2 = -v . dF/dt / v . m
/// v over the last step of dt [s]; `before`: the internal forces then.
template <int D>
double critical_rate(const State<D>& state, const VecArray<D>& before, double dt) {
  const Particles<D>& p = state.particles;
  double stiff = 0.0, heavy = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    stiff -= p.volume[i] * p.velocity[i].dot(state.internal[i] - before[i]);
    heavy += p.mass[i] * p.velocity[i].squaredNorm();
  }
  return heavy > 0.0 ? 2.0 * std::sqrt(std::max(0.0, stiff / (dt * heavy))) : 0.0;
}

/// Loads the soil in one increment and damps it near the critical rate of its slowest mode, pi c / H (xi about 3.6
/// h/H), until the largest acceleration is below 1e-3 of the driving one (gravity, or the largest external force).
/// From the first yielding on the damping follows the softer soil, down to a fiftieth: soil that can stand is found in
/// fewer steps, and soil that cannot runs away instead of creeping. It has four times as many steps then.
/// Displacements and stresses stay; velocities are cleared. external(drive) fills its forces, anew after every rebuild.
template <int D, class ExternalForce>
RestReport find_rest(const Setup<D>& setup, State<D>& state, ExternalForce&& external) {
  RestReport report;
  Particles<D>& p = state.particles;
  const std::size_t n = p.size();
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
  const double elastic_rate = 3.14159265358979 * speed / setup.height;
  drive.damping = elastic_rate;
  const double dt = setup.longest_substep;
  const auto limit = static_cast<std::size_t>(50.0 * setup.height / (speed * dt)) + 200;
  VecArray<D> before;
  while (report.steps < (state.any_yielded ? 4 * limit : limit)) {
    const double built = state.rebuilds;
    before = state.internal;
    substep<D>(setup, dt, drive, state);
    ++report.steps;
    if (state.any_yielded && state.rebuilds == built) {
      constexpr double memory = 0.95;  // about twenty steps
      const double rate = std::clamp(critical_rate(state, before, dt), 0.02 * elastic_rate, elastic_rate);
      drive.damping = memory * drive.damping + (1.0 - memory) * rate;
    }
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
  for (const auto& u : p.displacement) report.displacement = std::max(report.displacement, u.norm());
  for (auto& v : p.velocity) v.setZero();
  for (auto& gradient : p.gradient) gradient.setZero();
  evaluate_forces(setup, state);
  return report;
}

}  // namespace poretwin::solid
