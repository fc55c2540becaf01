// The equilibrium of soil at the end of a window: the displacements at which its forces balance.
#pragma once

#include "solid_solver/numerics/statics.hpp"
#include "solid_solver/statics/anderson.hpp"
#include "solid_solver/statics/rest.hpp"
#include "solid_solver/statics/stiffness.hpp"

namespace poretwin::solid {

/// All forces on the free particles [N], including hourglass control and artificial viscosity.
template <int D>
VecArray<D> all_forces(const Setup<D>& setup, const State<D>& state, const Drive<D>& drive) {
  VecArray<D> force = forces(setup, state, drive);
  for (std::size_t i = 0; i < force.size(); ++i) force[i] += state.particles.volume[i] * state.force[i].stabilising();
  return force;
}

/// Departure from rest [1] of soil under these unbalanced forces [N]: the error of its stress in the norm of the
/// elastic energy, over the stress that the reference acceleration [m/s2] causes.
template <int D>
double departure(const Stiffness<D>& stiffness, const VecArray<D>& force, double reference) {
  return stiffness.departure(stiffness.work(force), reference);
}
template <int D>
double departure(const Setup<D>& setup, const Stiffness<D>& stiffness, const State<D>& state, const Drive<D>& drive) {
  return departure(stiffness, all_forces(setup, state, drive), reference_acceleration(setup, state, drive));
}

/// Forces on the particles [N], averaged over their neighbourhoods by mass. The average removes forces that alternate
/// from one particle to the next: hourglass modes carry no stress, and in flowing soil nothing controls them.
template <int D>
VecArray<D> averaged(const Setup<D>& setup, const State<D>& state, const VecArray<D>& force) {
  const Particles<D>& p = state.particles;
  const double h = setup.smoothing_length, self = sph::WendlandC2<D>::value(0.0, h);
  VecArray<D> sum(force.size());
  ScalarArray mass(force.size());
  for (std::size_t i = 0; i < force.size(); ++i) {
    sum[i] = self * force[i];
    mass[i] = self * p.mass[i];
  }
  for_each_ordered_pair(state.near.pairs, [&](std::size_t i, std::size_t j, std::size_t) {
    if (i >= force.size() || j >= force.size()) return;
    const double w = sph::WendlandC2<D>::value((p.position[i] - p.position[j]).norm(), h);
    sum[i] += w * force[j];
    mass[i] += w * p.mass[j];
  });
  for (std::size_t i = 0; i < force.size(); ++i) sum[i] *= p.mass[i] / mass[i];
  return sum;
}

/// Criteria by which an equilibrium counts as found, and by which the search is given up.
struct EquilibriumSearch {
  double criterion = statics::criterion;  ///< departure from rest, as measured by Stiffness::departure()
  double local = 0.0;  ///< fraction of the mass that may continue to move in soil that yields, once the remaining soil
                       ///< is at rest
  double moving = statics::woken_by;  ///< a particle counts as moving above this averaged force per mass, relative to
                                      ///< the reference acceleration
  std::size_t most = statics::most_tried;  ///< largest number of trial displacements
};

/// Distance of a search from equilibrium. share: fraction of the mass whose averaged force exceeds a bound; rest:
/// departure from rest of the remaining particles.
struct Unsettled {
  double share = 1.0, rest = 0.0;
};
template <int D>
Unsettled unsettled(const Setup<D>& setup, const Stiffness<D>& stiffness, double moving, const State<D>& state,
                    const VecArray<D>& force, double reference) {
  VecArray<D> left = averaged(setup, state, force);
  const auto moves = [&](std::size_t i) { return left[i].norm() > moving * reference * state.particles.mass[i]; };
  Unsettled result{share_of_mass(setup.domain, state.particles, moves)};
  for (std::size_t i = 0; i < left.size(); ++i)
    if (moves(i)) left[i].setZero();
  result.rest = departure(stiffness, left, reference);
  return result;
}

/// Decides whether all but a local part of the soil is at rest. The local part may be twice as large when further
/// trials gain nothing; it then continues to creep in the next window. ends() is called once every few trials.
class Patience {
 public:
  /// departure: departure from rest of the whole soil.
  bool ends(const EquilibriumSearch& search, double departure, const Unsettled& left) {
    const bool stalls = left.share > (1.0 - statics::least_gain) * shares_.back();
    std::rotate(shares_.begin(), shares_.end() - 1, shares_.end());
    shares_.front() = left.share;
    if (left.rest >= search.criterion || departure >= statics::near_criterion * search.criterion) return false;
    return left.share < search.local || (stalls && left.share < statics::stalled_share * search.local);
  }

 private:
  std::array<double, 4> shares_{1.0, 1.0, 1.0, 1.0};
};

/// Sets the stress to zero in grains that are apart or have been apart in one of the trials (apart[i] = 1). If contacts
/// came and went with every trial, no equilibrium could be found.
template <int D>
void leave_out(const Setup<D>& setup, State<D>& state, std::vector<char>& apart) {
  Particles<D>& p = state.particles;
  for (std::size_t i = 0; i < apart.size(); ++i) {
    if (p.rubbing[i] > 0.0F) apart[i] = 1;
    if (!apart[i]) continue;
    p.stress[i].setZero();
    p.rubbing[i] = setup.loose_friction[p.material[i]];
  }
}

/// Undoes the last trial displacement: restores the values that it changed and that the next forces do not overwrite.
template <int D>
void restore_state(const State<D>& start, State<D>& state) {
  if (state.rebuilds > start.rebuilds) state.near = start.near;
  state.rebuilds = start.rebuilds;
  state.particles = start.particles;
  state.nodes = start.nodes;
  state.kernel = start.kernel;
  state.yielded = start.yielded;
  state.any_yielded = start.any_yielded;
}

/// Finds the equilibrium of the soil at the end of a window of `interval` [s] by one step of backward Euler.
/// external(drive, rebuilt) sets the external forces in `drive` for each trial displacement; `rebuilt` says whether the
/// pair lists are new.
///
/// Every trial starts from the state at the window's start, so that stress is returned to the cone once, over the
/// strain of the whole window. If each trial continued from the previous one, the plastic strain of all detours of the
/// search would add up. The search is given up after search.most trials, or when a particle moves farther than
/// statics::farthest or, in soil that cannot yield, statics::farthest_elastic; the initial state is then restored.
template <int D, class ExternalForce>
RestReport find_equilibrium(const Setup<D>& setup, const Stiffness<D>& stiffness, const EquilibriumSearch& search,
                            double interval, State<D>& state, ExternalForce&& external) {
  constexpr Eigen::Index depth = 12;
  using Flat = Eigen::Map<Eigen::VectorXd>;
  RestReport report;
  report.criterion = search.criterion;
  const std::size_t n = state.particles.free();
  // The plates' displacements along their normals are searched for as well, and those of their ends as they turn.
  const std::vector<PlateFreedom> freedoms = freedoms_of(setup.plates);
  const auto of_soil = static_cast<Eigen::Index>(n * D), of_plates = static_cast<Eigen::Index>(freedoms.size());
  const Eigen::Index size = of_soil + of_plates;
  const State<D> start = state;
  ScalarArray held = start.particles.plastic_strain;
  std::vector<char> apart(n, 0);
  Drive<D> drive;
  external(drive, true);
  const double reference = reference_acceleration(setup, state, drive);
  Eigen::VectorXd all = Eigen::VectorXd::Zero(size), missing(size), towards(size), plates_towards;
  Anderson accelerated(size, depth);
  Patience patience;
  bool was_rebuilt = false;  // by the last trial
  const double farthest =
      std::max(statics::farthest * setup.spacing, setup.can_yield ? 0.0 : statics::farthest_elastic * setup.height);
  for (;; ++report.steps) {
    if (report.steps > 0) restore_state(start, state);
    for (std::size_t i = 0; i < n; ++i)
      state.particles.velocity[i] = all.segment<D>(static_cast<Eigen::Index>(i * D)) / interval;
    for (std::size_t k = 0; k < setup.plates.size(); ++k) {
      PlateMotion<D>& plate = state.particles.plates[k];
      plate.velocity = (drive.plates[k].target - plate.displacement) / interval;
    }
    for (std::size_t f = 0; f < freedoms.size(); ++f) {
      const PlateSetup<D>& plate = setup.plates[freedoms[f].plate];
      PlateMotion<D>& motion = state.particles.plates[freedoms[f].plate];
      const double speed = all[of_soil + static_cast<Eigen::Index>(f)] / interval;
      if (freedoms[f].turns)
        motion.spin = speed / plate.half;
      else
        motion.velocity += (speed - plate.normal.dot(motion.velocity)) * plate.normal;
    }
    deform<D>(setup, interval, nullptr, state);
    leave_out(setup, state, apart);
    // Loads follow the kernels, which must be those of the pairs at hand: of new ones where this trial has rebuilt
    // them, and of the window's start again after a trial that had.
    const bool rebuilt = rebuild_if_moved(setup, state);
    if (rebuilt) evaluate_kernels(setup, state);
    external(drive, rebuilt || was_rebuilt);
    was_rebuilt = rebuilt;
    for (std::size_t i = 0; i < n; ++i)
      state.body[i] = (state.particles.mass[i] * setup.gravity + drive.distributed[i]) / state.particles.volume[i];
    std::swap(state.particles.plastic_strain, held);
    evaluate_forces(setup, state);
    std::swap(state.particles.plastic_strain, held);
    VecArray<D> force = all_forces(setup, state, drive);
    for (std::size_t i = 0; i < n; ++i)
      if (apart[i]) force[i].setZero();
    missing.head(of_soil) = Flat(force.data()->data(), of_soil);
    for (std::size_t f = 0; f < freedoms.size(); ++f)
      missing[of_soil + static_cast<Eigen::Index>(f)] = unbalanced(setup, state, drive, freedoms[f]);
    VecArray<D> step = stiffness.displacements(force, missing.tail(of_plates), plates_towards);
    towards.head(of_soil) = Flat(step.data()->data(), of_soil);
    towards.tail(of_plates) = plates_towards;
    report.residual = stiffness.departure(missing.dot(towards), reference);
    if (report.steps == search.most || !std::isfinite(report.residual)) break;
    report.creeps =
        search.local > 0.0 && state.any_yielded && report.steps % statics::looks_every == 0 &&
        patience.ends(search, report.residual, unsettled(setup, stiffness, search.moving, state, force, reference));
    if (report.reached()) {
      // Hourglass control ends where soil yields, but only between two searches. If every trial switched it, no
      // equilibrium could be found.
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
    if (all.cwiseAbs().maxCoeff() > farthest) break;  // plates included
  }
  if (!report.reached()) state = start;
  return report;
}

}  // namespace poretwin::solid
