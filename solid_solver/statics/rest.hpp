// The soil at rest: dynamic relaxation to an equilibrium, and initial stresses of level ground.
#pragma once

#include "solid_solver/numerics/statics.hpp"
#include "solid_solver/sleep/quiet.hpp"

#include <limits>
#include <map>

namespace poretwin::solid {

struct RestReport {
  std::size_t steps = 0;
  double displacement = 0.0;  ///< m, largest displacement of a particle
  double residual = 0.0;      ///< largest acceleration (without damping) over the reference acceleration
  bool creeps = false;        ///< all but a small part of the soil is at rest; this part yields
  bool slides = false;        ///< the search was given up because a particle moved too far
  /// Set when a search found no rest: the largest acceleration, over the reference acceleration, that corresponds to
  /// the soil's motion in the last quarter of the search. It ignores stress that alternates in a yielding grain without
  /// moving the grain on.
  double drift = std::numeric_limits<double>::infinity();
  double criterion = 0.0;  ///< rest is found when the residual is below this; 0: no search for rest
  [[nodiscard]] bool reached() const { return residual < criterion || creeps || drift < criterion; }
};

/// Criteria by which rest counts as found, and by which the search is given up.
struct RestSearch {
  double criterion = statics::rest_criterion;     ///< largest acceleration at rest, over the reference acceleration
  double ways = statics::rest_ways;               ///< longest search, in times in which an elastic wave crosses the
                                                  ///< soil's height
  double yielding = statics::rest_ways_yielding;  ///< longest search once soil yields, in the same unit
  double local = 0.0;                             ///< fraction of the mass that may continue to move in yielding soil
  double farthest = std::numeric_limits<double>::infinity();  ///< m, displacement at which the search is given up
  bool drifts = false;  ///< soil also counts as at rest where its motion has no drift (RestReport::drift)
};

/// Rate that damps the present motion critically, 2 omega [1/s], with Rayleigh's quotient omega^2 = -v . dF/dt / (v . m
/// v) over the last step of dt [s] (Underwood 1983). before, now: forces on the particles [N] at its start and end.
template <int D>
double critical_rate(const Domain& domain, const State<D>& state, const VecArray<D>& before, const VecArray<D>& now,
                     double dt) {
  const Particles<D>& p = state.particles;
  double stiff = 0.0, heavy = 0.0;
  for (std::size_t i = 0; i < p.free(); ++i) {
    stiff -= p.velocity[i].dot(now[i] - before[i]);
    heavy += p.mass[i] * p.velocity[i].squaredNorm();
  }
  stiff = domain.sum(stiff);
  heavy = domain.sum(heavy);
  return heavy > 0.0 ? 2.0 * std::sqrt(std::max(0.0, stiff / (dt * heavy))) : 0.0;
}

/// Largest displacement since `start` [m].
template <int D>
double farthest_moved(const Domain& domain, const State<D>& state, const VecArray<D>& start) {
  double farthest = 0.0;
  for (std::size_t i = 0; i < state.particles.free(); ++i)
    farthest = std::max(farthest, (state.particles.displacement[i] - start[i]).norm());
  return domain.max(farthest);
}

/// Dynamic relaxation from the present state. external(drive, rebuilt) sets the forces from outside after every step.
/// rebuilt: whether the pair lists are new.
///
/// The damping is critical for the lowest frequency that the motion shows, and at least for the slowest mode of a
/// column of the soil's height. From the first yielding on, it is reduced with the stiffness of the soil, to at least a
/// fiftieth of the elastic value. Then stable soil comes to rest in fewer steps, and unstable soil accelerates visibly.
/// Velocities are used only in the search and are zero at its end. show(report) is called at every hundredth step and
/// at the last step. The search also ends when `given_up` is set.
template <int D, class ExternalForce, class Show>
RestReport find_rest(const Setup<D>& setup, const RestSearch& search, State<D>& state, ExternalForce&& external,
                     Show&& show, const bool& given_up = false) {
  RestReport report;
  Drive<D> drive;
  drive.timeless = true;
  external(drive, true);
  report.criterion = search.criterion;
  const double reference = reference_acceleration(setup, state, drive);
  if (reference <= 0.0) return report;
  const double elastic_rate = near_critical_damping(setup);
  drive.damping = elastic_rate;
  const double dt = setup.rest_substep;
  const auto limit = [&] {
    const double ways = state.any_yielded ? search.yielding : search.ways;
    return static_cast<std::size_t>(ways * setup.height / (setup.stabilisers.sound_speed * dt)) + 200;
  };
  VecArray<D> before, now = forces(setup, state, drive);
  const VecArray<D> start = state.particles.displacement;
  VecArray<D> late;  // displacements at the start of the search's last quarter
  double late_damping = 0.0;
  std::size_t late_steps = 0;
  do {
    const double built = state.rebuilds;
    substep<D>(setup, dt, drive, state);
    ++report.steps;
    external(drive, state.rebuilds > built);
    std::swap(before, now);
    now = forces(setup, state, drive);
    if (setup.domain.all(state.rebuilds == built)) {
      const double rate = critical_rate(setup.domain, state, before, now, dt);
      drive.damping = state.any_yielded ? statics::damping_memory * drive.damping +
                                              (1.0 - statics::damping_memory) *
                                                  std::clamp(rate, statics::least_damping * elastic_rate, elastic_rate)
                                        : std::max(rate, elastic_rate);
    }
    if (search.drifts && late.empty() && 4 * report.steps >= 3 * limit()) late = state.particles.displacement;
    if (!late.empty()) {
      late_damping += drive.damping;
      ++late_steps;
    }
    const Unrest left = unrest<D>(setup, state, std::span<const Vec<D>>(now), reference);
    report.residual = std::max(left.largest, acceleration_of_plates(setup, state, drive) / reference);
    report.creeps = state.any_yielded && left.share < search.local;
    if (report.steps % 100 == 0) report.slides = farthest_moved(setup.domain, state, start) > search.farthest;
    check_sound(setup, state, state.time);
    if (report.steps % 100 == 0) show(report);
  } while (!report.reached() && !report.slides && !given_up && report.steps < limit());
  if (!report.reached() && late_steps > 0)  // damped motion continues at the speed force / damping
    report.drift = late_damping / static_cast<double>(late_steps) * farthest_moved(setup.domain, state, late) /
                   (static_cast<double>(late_steps) * dt) / reference;
  for (const auto& u : state.particles.displacement) report.displacement = std::max(report.displacement, u.norm());
  report.displacement = setup.domain.max(report.displacement);
  stop(setup, state);
  show(report);
  return report;
}

/// Sets the stresses of level ground: the vertical stress by the weight (and the water's force) above each particle,
/// the horizontal stresses by the soil's coefficient of earth pressure at rest, K0. Soils without K0 keep their stress.
template <int D>
void start_from_earth_pressure(const Setup<D>& setup, const std::vector<Soil>& soils, const Drive<D>& drive,
                               State<D>& state) {
  Particles<D>& p = state.particles;
  const Vec<D> up = upwards(setup);
  struct Entry {
    double level;
    std::size_t particle;
  };
  std::map<std::array<long, D>, std::vector<Entry>> columns;  // by position across gravity, one spacing wide
  for (std::size_t i = 0; i < p.free(); ++i) {
    const double level = up.dot(p.position[i]);
    const Vec<D> across = p.position[i] - level * up;
    std::array<long, D> place;
    for (int d = 0; d < D; ++d)
      place[static_cast<std::size_t>(d)] = std::lround(std::floor(across[d] / setup.spacing + 1e-6));
    columns[place].push_back({level, i});
  }
  const double area = std::pow(setup.spacing, D - 1);
  for (auto& [place, column] : columns) {
    std::sort(column.begin(), column.end(), [](const Entry& a, const Entry& b) { return a.level > b.level; });
    double above = 0.0;  // N, force on the plane through the particle
    for (const auto& entry : column) {
      const std::size_t i = entry.particle;
      const double weight = -up.dot(p.mass[i] * setup.gravity + force_from_outside(drive, i));
      const double vertical = -(above + 0.5 * weight) / area;
      above += weight;
      const auto& k0 = soils[p.material[i]].earth_pressure_at_rest;
      if (!k0) continue;
      Eigen::Vector3d direction = Eigen::Vector3d::Zero();
      direction.head<D>() = up;
      const Eigen::Matrix3d lifted = direction * direction.transpose();
      const Eigen::Matrix3d s = vertical * (lifted + *k0 * (Eigen::Matrix3d::Identity() - lifted));
      p.stress[i] << s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(0, 2);
    }
  }
  evaluate_forces(setup, state);
}

}  // namespace poretwin::solid
