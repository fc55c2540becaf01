// The equilibrium of soil at the end of a window: displacements by which nothing is missing in its balance of forces.
#pragma once

#include "solid_solver/anderson.hpp"
#include "solid_solver/rest.hpp"
#include "solid_solver/stiffness.hpp"

namespace poretwin::solid {

/// All forces on the particles [N], those that hold the zero-energy modes and viscosity included.
template <int D>
VecArray<D> all_forces(const Setup<D>& setup, const State<D>& state, const Drive<D>& drive) {
  VecArray<D> force = forces(setup, state, drive);
  for (std::size_t i = 0; i < force.size(); ++i) force[i] += state.particles.volume[i] * state.stabilising[i];
  return force;
}

/// How far from rest the soil is, as Stiffness::departure() measures it.
template <int D>
double departure(const Setup<D>& setup, const Stiffness<D>& stiffness, const State<D>& state, const Drive<D>& drive) {
  const VecArray<D> force = all_forces(setup, state, drive), moved = stiffness.displacements(force);
  double work = 0.0;
  for (std::size_t i = 0; i < force.size(); ++i) work += force[i].dot(moved[i]);
  return stiffness.departure(work, reference_acceleration(setup, state, drive));
}

/// When an equilibrium is found and when the search is given up.
struct EquilibriumSearch {
  double criterion = 4e-4;  ///< departure from rest as Stiffness::departure() measures it
  std::size_t most = 150;   ///< displacements tried
};

/// Finds where the soil stands at the end of a window of `interval` [s] under the forces that external(drive, rebuilt)
/// fills for a displacement tried: one step of backward Euler. Stress is returned to the cone once, over the window's
/// whole strain, whatever was tried on the way: a search that follows its way through the cone gathers the plastic
/// strain of its detours. Given up when nothing is found in time, or something moves by more than half a spacing; the
/// state is then as it was.
template <int D, class ExternalForce>
RestReport find_equilibrium(const Setup<D>& setup, const Stiffness<D>& stiffness, const EquilibriumSearch& search,
                            double interval, State<D>& state, ExternalForce&& external) {
  constexpr Eigen::Index depth = 12;
  using Flat = Eigen::Map<Eigen::VectorXd>;
  RestReport report;
  report.criterion = search.criterion;
  const std::size_t n = state.particles.free();
  const auto size = static_cast<Eigen::Index>(n * D);
  const State<D> start = state;
  ScalarArray held = start.particles.plastic_strain;
  Drive<D> drive;
  external(drive, true);
  const double reference = reference_acceleration(setup, state, drive);
  VecArray<D> moved(n, Vec<D>::Zero());
  Flat all(moved.data()->data(), size);
  Anderson accelerated(size, depth);
  for (;; ++report.steps) {
    if (report.steps > 0) state = start;
    for (std::size_t i = 0; i < n; ++i) state.particles.velocity[i] = moved[i] / interval;
    deform(setup, interval, state);
    external(drive, rebuild_if_moved(setup, state));
    for (std::size_t i = 0; i < n; ++i)
      state.body[i] = (state.particles.mass[i] * setup.gravity + drive.distributed[i]) / state.particles.volume[i];
    std::swap(state.particles.plastic_strain, held);
    evaluate_forces(setup, state);
    std::swap(state.particles.plastic_strain, held);
    VecArray<D> force = all_forces(setup, state, drive), step = stiffness.displacements(force);
    const Flat missing(force.data()->data(), size), towards(step.data()->data(), size);
    report.residual = stiffness.departure(missing.dot(towards), reference);
    if (report.steps == search.most || !std::isfinite(report.residual)) break;
    if (report.reached()) {
      // What holds the zero-energy modes lets go of soil that yields; back and forth with every trial there would be no
      // equilibrium to find.
      bool lets_go = false;
      for (std::size_t i = 0; i < held.size(); ++i) {
        if (held[i] > 0.0 || state.particles.plastic_strain[i] <= 0.0) continue;
        held[i] = state.particles.plastic_strain[i];
        lets_go = true;
      }
      if (!lets_go) break;
      accelerated = Anderson(size, depth);
      continue;
    }
    all += accelerated.move(missing, towards);
    if (all.cwiseAbs().maxCoeff() > 0.5 * setup.spacing) break;
  }
  if (!report.reached()) state = start;
  return report;
}

}  // namespace poretwin::solid
