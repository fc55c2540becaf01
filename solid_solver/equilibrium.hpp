// Equilibrium of soil that does not yield: conjugate gradients on the forces that the soil itself returns.
#pragma once

#include "solid_solver/rest.hpp"

#include "solid_solver/stiffness.hpp"

namespace poretwin::solid {

/// All forces on soil that stands still [N], those that hold the zero-energy modes included.
template <int D>
VecArray<D> standing_forces(const Setup<D>& setup, const State<D>& state, const Drive<D>& drive) {
  VecArray<D> force = forces(setup, state, drive);
  for (std::size_t i = 0; i < force.size(); ++i) force[i] += state.particles.volume[i] * state.stabilising[i];
  return force;
}

/// How far from rest the soil is, as Stiffness::departure() measures it.
template <int D>
double departure(const Setup<D>& setup, const Stiffness<D>& stiffness, const State<D>& state, const Drive<D>& drive) {
  const VecArray<D> force = standing_forces(setup, state, drive), moved = stiffness.displacements(force);
  double work = 0.0;
  for (std::size_t i = 0; i < force.size(); ++i) work += force[i].dot(moved[i]);
  return stiffness.departure(work, reference_acceleration(setup, state, drive));
}

/// Moves the soil by a displacement [m] without regard to time; external(drive, rebuilt) then fills what acts on it.
template <int D, class ExternalForce>
void displace(const Setup<D>& setup, const VecArray<D>& by, State<D>& state, Drive<D>& drive,
              ExternalForce&& external) {
  Particles<D>& p = state.particles;
  std::copy(by.begin(), by.end(), p.velocity.begin());
  deform(setup, 1.0, state);
  for (auto& v : p.velocity) v.setZero();
  for (auto& g : p.gradient) g.setZero();
  external(drive, rebuild_if_moved(setup, state));
  for (std::size_t i = 0; i < p.free(); ++i)
    state.body[i] = (p.mass[i] * setup.gravity + drive.distributed[i]) / p.volume[i];
  evaluate_forces(setup, state);
}

/// Finds the rest of soil that does not yield: preconditioned conjugate gradients, one displacement an iteration, whose
/// product of stiffness and direction is the change of force that it made. `criterion`: departure from rest in the norm
/// of Stiffness::departure() at which it ends. Where the soil yields, or after `most` displacements, the search is
/// given up and the report says not reached.
template <int D, class ExternalForce>
RestReport find_elastic_rest(const Setup<D>& setup, const Stiffness<D>& stiffness, double criterion, std::size_t most,
                             State<D>& state, ExternalForce&& external) {
  RestReport report;
  report.criterion = criterion;
  const std::size_t n = state.particles.free();
  const auto dot = [n](const VecArray<D>& a, const VecArray<D>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < n; ++i) sum += a[i].dot(b[i]);
    return sum;
  };
  Drive<D> drive;
  external(drive, true);
  const double reference = reference_acceleration(setup, state, drive);
  VecArray<D> force = standing_forces(setup, state, drive), balanced = stiffness.displacements(force);
  VecArray<D> direction = balanced, move(n, Vec<D>::Zero()), change(n), left(n);
  double work = dot(force, balanced), step = 1.0;
  report.residual = stiffness.departure(work, reference);
  while (!report.reached() && report.steps < most) {
    for (std::size_t i = 0; i < n; ++i) move[i] += step * direction[i];
    displace(setup, move, state, drive, external);
    ++report.steps;
    const VecArray<D> now = standing_forces(setup, state, drive);
    for (std::size_t i = 0; i < n; ++i) change[i] = (force[i] - now[i]) / step;
    const double stiff = dot(direction, change);
    if (state.any_yielded || !(stiff > 0.0)) break;
    const double best = dot(direction, force) / stiff;
    for (std::size_t i = 0; i < n; ++i) {
      left[i] = force[i] - best * change[i];
      move[i] = (best - step) * direction[i];  // what the next displacement makes good
    }
    step = best;
    balanced = stiffness.displacements(left);
    const double overlap = dot(left, balanced) - dot(force, balanced);  // Polak & Ribiere: forgets what does not fit
    const double carried = std::max(0.0, overlap / work);
    work = dot(left, balanced);
    std::swap(force, left);
    for (std::size_t i = 0; i < n; ++i) direction[i] = balanced[i] + carried * direction[i];
    report.residual = stiffness.departure(work, reference);
  }
  displace(setup, move, state, drive, external);
  check_sound(setup, state, state.time);
  if (state.any_yielded) report.residual = std::numeric_limits<double>::infinity();
  return report;
}

}  // namespace poretwin::solid
