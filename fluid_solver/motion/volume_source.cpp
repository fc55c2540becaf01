#include "fluid_solver/motion/volume_source.hpp"

#include "fluid_solver/discretisation/bodies.hpp"
#include "fluid_solver/discretisation/operators.hpp"
#include "fluid_solver/motion/packing.hpp"
#include "fluid_solver/motion/step_limits.hpp"
#include "fluid_solver/numerics/exchange.hpp"
#include "fluid_solver/numerics/motion.hpp"
#include "fluid_solver/regimes.hpp"

#include <cmath>

namespace poretwin::fluid {

namespace {

/// The part of the divergence [1/s] left by the last window's solve that is deferred to later windows, in free water
/// with one-sided neighbours. If the window is shorter than half the longest window that a particle's motion allows,
/// only the ratio of the two is removed, for each particle separately.
///
/// With few neighbours on one side, a pressure gradient can reverse a divergence and leave it larger by a few percent
/// per solve, whatever the window's length. In many short windows it would grow until the water flies apart. The first
/// window removes all of the initial divergence.
///
/// Nothing is deferred in soil. Soil that falls on a floor closes the film of water under it within a millisecond. If
/// the film could be compressed for the several milliseconds of a deferral, it would absorb the blow and return it. A
/// particle half covered by soil defers half. Nor is anything deferred beside soil in which drag dominates: there the
/// flux through the soil's edge (SoilEdge) determines the divergence, and not the pairs' means. Of these a sink would
/// remain in every window.
template <int D>
ScalarArray deferred_divergence(const Setup<D>& setup, const State<D>& state, const Stencil<D>& s,
                                const SoilView<D>& view, double interval) {
  const auto& p = state.particles;
  ScalarArray deferred(p.size(), 0.0);
  if (setup.scheme != FluidCase::Scheme::projection || state.last_interval <= 0.0) return deferred;
  std::vector<char> held(p.size(), 0);  // by the soil
  parallel_for(p.size(), [&](std::size_t a) { held[a] = is_drag_dominated<D>(setup, p, view, a) ? 1 : 0; });
  const bool any_held = s.domain.any_of(p.size(), [&](std::size_t a) { return held[a] != 0; });
  const std::vector<char> holds = any_held ? s.flags_with_copies(held) : std::vector<char>();
  const auto touches_soil = [&](std::size_t a) {
    for (Index k = s.offset[a]; !holds.empty() && k < s.offset[a + 1]; ++k)
      if (const Index q = s.parent[s.other[k]]; q < s.n_particles && holds[q] != 0) return true;
    return false;
  };
  parallel_for(p.size(), [&](std::size_t a) {
    if (p.in_seepage[a] == 0 && held[a] == 0 && s.length(a) * s.normal[a].norm() > motion::even_surroundings &&
        !touches_soil(a))
      deferred[a] = (1.0 - view.mask[a]) * std::max(0.0, 1.0 - interval / (0.5 * free_interval<D>(setup, p, a)));
  });
  if (s.domain.all_of(p.size(), [&](std::size_t a) { return deferred[a] == 0.0; })) return deferred;
  VecArray<D> flux(p.size());
  parallel_for(p.size(), [&](std::size_t a) {
    flux[a] = p.void_fraction[a] * p.velocity[a] + view.fraction[a] * p.solid_velocity[a];
  });
  const ScalarArray outflow = divergence<D>(s, flux, Carried::yes);
  parallel_for(p.size(), [&](std::size_t a) { deferred[a] *= outflow[a]; });
  return deferred;
}

/// Rate of expansion [1/s] of the soil that the water cannot see in the mapped velocity, as it is applied to the water.
/// Where rows of soil slide past each other, the soil's kernel sums expand and contract by some 6e-4 of the shear,
/// which the mapped velocity does not show. Undrained soil that expands by 1e-4 loses all its strength. Therefore the
/// volumetric strain that the soil itself integrates enters the water's volume balance (decision 0021). The rate is
/// averaged over some windows, since a single window also contains the soil's shortest waves, which the mapping
/// smooths. The average loses no part of the strain.
template <int D>
ScalarArray unseen_strain_rate(State<D>& state, const Stencil<D>& s, const SoilView<D>& view, double interval) {
  auto& p = state.particles;
  const double came = state.last_interval;
  state.usual_interval += (came - state.usual_interval) / exchange::unseen_strain_windows;
  const double memory = exchange::unseen_strain_windows * std::max({state.usual_interval, came, interval});
  for (auto* values : {&p.unseen_rate, &p.unseen_strain})
    if (!values->is_allocated()) values->allocate(p.size());
  const auto shown = divergence<D>(s, view.mean_velocity.values());
  std::vector<char> covered(p.size());
  parallel_for(p.size(), [&](std::size_t a) { covered[a] = view.mask[a] > 0.0 ? 1 : 0; });
  covered = s.flags_with_copies(covered);
  ScalarArray applied(p.size());
  parallel_for(p.size(), [&](std::size_t a) {
    bool within = covered[a] != 0;  // inside only: at the soil's edge the divergence contains the end of the soil
    for (Index k = s.offset[a]; k < s.offset[a + 1] && within; ++k)
      if (const Index q = s.parent[s.other[k]]; q < s.n_particles) within = covered[q] != 0;
    const double rate = within ? view.strain_rate[a] - shown[a] : 0.0;
    const double strain = p.unseen_strain[a] + rate * came;
    // Critically damped, in proportion to the window: a short one, cut at an output instant, does not jerk the soil.
    const double wanted = rate + strain / (4.0 * memory);
    applied[a] = p.unseen_rate[a] + (wanted - p.unseen_rate[a]) * interval / memory;
    p.unseen_rate.set(a, applied[a]);
    p.unseen_strain.set(a, strain - applied[a] * interval);
  });
  return applied;
}

}  // namespace

/// True in 2D where the pressure is solved for. In 3D density_weight has no advantage, and with explicit sweeps results
/// are worse with it. It is not used beside soil (Stencil::open_water), where it would add 1 % to the energy in a thin
/// fast layer.
template <int D>
bool uses_density_weight(const Setup<D>& setup) {
  return D == 2 && setup.is_projection();
}

template <int D>
double free_repair_time(const Setup<D>& setup, double spacing) {
  return motion::free_repair_falls * std::sqrt(spacing / setup.gravity_or_standard);
}

template <int D>
ScalarArray moved(const Particles<D>& p) {
  ScalarArray result(p.size());
  parallel_for(p.size(), [&](std::size_t a) {
    const double spacing = spacing_of<D>(p.volume[a]);
    const double counts =
        (p.in_seepage[a] != 0 ? motion::repair_displacement : motion::free_repair_displacement) * spacing;
    result[a] = std::min(1.0, (p.position[a] - p.birthplace[a]).norm() / counts);
  });
  return result;
}

namespace {

/// Time of the repair of the packing. In soil: a third of the time in which a unit gradient drives water through one
/// spacing, and at most the time in which the flow passes one. (Pair sums conserve the square of the concentration
/// times the velocity, so that loose water runs ahead and becomes looser.) In free water: twenty times a fall through
/// one spacing or, where drag slows the water, twenty times n rho_w / C. It is a physical time, not a number of
/// windows; but never less than two windows, since a faster repair oscillates. speed [m/s]: of the flow.
template <int D>
double repair_time_at(const Setup<D>& setup, const Particles<D>& p, std::size_t a, const SoilView<D>& view,
                      double interval, double speed) {
  const double spacing = spacing_of<D>(p.volume[a]),
               weight = setup.density * setup.gravity_or_standard * p.void_fraction[a];
  const double pushed = motion::pushed_repair * spacing * view.drag[a] / weight;
  const double passed = spacing / std::max(speed, 1e-300);
  const double held =
      view.drag[a] > 0.0 ? motion::held_repair_times * p.void_fraction[a] * setup.density / view.drag[a] : HUGE_VAL;
  return std::max(
      {motion::repair_windows * interval, std::min(free_repair_time(setup, spacing), held), std::min(pushed, passed)});
}

/// Fraction of the mixture's volume that moved with the skeleton in the last window: the grains, and the part of the
/// pore water that drag moved against its inertia.
template <int D>
double moves_with_soil(const Setup<D>& setup, const State<D>& state, const SoilView<D>& view, std::size_t a) {
  const double n = state.particles.void_fraction[a], aw = n * setup.density / state.last_interval;
  return view.fraction[a] + n * view.drag[a] / (aw + view.drag[a]);
}

/// Fraction of the repair of the packing that moves the soil, too. At the rate at which water passes through the soil,
/// water alone moves, as in soil at rest. What the soil's own motion adds to that rate moves the points of soil and
/// water together. This evens out points and is no strain of the soil: if the skeleton counted it as strain, packing
/// errors of 1e-4 would cause hundreds of Pa of effective stress (decision 0031).
template <int D>
double taken_along(const Setup<D>& setup, const Particles<D>& p, std::size_t a, const SoilView<D>& view,
                   double interval) {
  if (p.in_seepage[a] != 0 || p.mask[a] <= motion::in_soil) return 0.0;
  const double through = (p.velocity[a] - p.mask[a] * p.solid_velocity[a]).norm();
  return std::max(
      0.0, 1.0 - repair_time<D>(setup, p, a, view, interval) / repair_time_at<D>(setup, p, a, view, interval, through));
}

}  // namespace

template <int D>
double repair_time(const Setup<D>& setup, const Particles<D>& p, std::size_t a, const SoilView<D>& view,
                   double interval) {
  return repair_time_at<D>(setup, p, a, view, interval, p.velocity[a].norm());
}

template <int D>
double packing_error(const Setup<D>& setup, const Particles<D>& p, const Stencil<D>& s, std::size_t a, double full,
                     bool loose_counts) {
  if (uses_density_weight(setup) && s.open_water[a] != 0 && p.surface[a] != Surface::lone) {
    if (const double below = depth<D>(s, a); below > 0.0) {
      // A lattice fills the missing side beyond the surface.
      static const double whole = lattice_density<D>();
      const double error = full + lattice_density<D>(0.5 + below * points::smoothing_ratio / s.length(a)) / whole - 1.0;
      return loose_counts ? error : std::max(0.0, error);
    }
  }
  double excess = full - 1.0;
  // Near a surface the kernel is cut off: a deficit there is no packing error.
  if (excess < 0.0 && !s.covered[a])
    excess *= std::clamp(1.0 - motion::cut_off * s.length(a) * s.normal[a].norm(), 0.0, 1.0);
  const bool below = s.ghost_distance[a] > 0.0;
  return below || p.surface[a] != Surface::interior ? std::max(0.0, excess) : excess;
}

template <int D>
ScalarArray volume_source(const Setup<D>& setup, State<D>& state, const Stencil<D>& s, const SoilView<D>& view,
                          std::span<const Mat<D>> velocity_gradient, double interval) {
  auto& p = state.particles;
  ScalarArray source = deferred_divergence<D>(setup, state, s, view, interval);
  // Pressure repairs a packing error by moving the surface or the inflow. A body of water that only walls surround has
  // neither: there pressure would only push on the grains, and shifting alone evens out the packing. Where all soil is
  // full of water, no flow driven by pressure can even out the points: they are displaced instead (repair).
  auto motion = !state.full ? moved<D>(state.particles) : ScalarArray(p.size(), 0.0);
  if (p.closed_body.is_allocated())
    parallel_for(p.size(), [&](std::size_t a) { motion[a] *= p.closed_body[a] == 0 ? 1.0 : 0.0; });
  // Voids opened by cavitation are not packing errors.
  const bool cavitates =
      s.domain.any(std::any_of(p.void_volume.begin(), p.void_volume.end(), [](double c) { return c > 0.0; }));
  ScalarArray own_voids(cavitates ? p.size() : 0);  // bulk volume, m^D
  for (std::size_t a = 0; a < own_voids.size(); ++a) own_voids[a] = p.void_volume[a] / p.void_fraction[a];
  const WithCopies<double> voids(cavitates ? s.domain : Domain(), own_voids);
  const auto voids_near = [&](std::size_t a) {
    if (!cavitates) return 0.0;
    double sum = voids[a] * Kernel<D>::value(0.0, s.length(a));
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k)
      if (const Index q = s.parent[s.other[k]]; q < s.n_particles && voids[q] > 0.0)
        sum += voids[q] * s.value(a, s.other[k]);
    return sum / lattice_fullness<D>();
  };
  // Particles that divide and merge beside a bed leave the packing uneven, and a pond may be shallower than the
  // kernel's reach: its looseness is repaired up to the surface. Elsewhere looseness below a surface is no error: flow
  // stretches rows there, and to draw them together again lowers the surface of a tank by up to 0.07 spacings.
  const bool loose_counts = !state.bed.empty();
  ScalarArray spreading(setup.responds ? p.size() : 0, 0.0);
  parallel_for(p.size(), [&](std::size_t a) {
    const double excess = packing_error<D>(setup, state.particles, s, a, s.fullness[a] + voids_near(a), loose_counts);
    // In free water the repair of a disordered start begins gradually, since a sudden repair would act as an impact.
    const double begun =
        p.in_seepage[a] != 0 ? 1.0 : std::min(1.0, state.time / free_repair_time(setup, spacing_of<D>(p.volume[a])));
    const double repaired =
        begun * motion[a] * p.void_fraction[a] * excess / repair_time<D>(setup, state.particles, a, view, interval);
    source[a] += repaired;
    if (setup.responds) spreading[a] = repaired * taken_along<D>(setup, p, a, view, interval);
    // Makes volume exact to second order in the displacement: det(1 + dt grad v) = 1. Without this term, a strain rate
    // s compresses the water at the rate dt s^2, and the repair of that compression adds energy.
    if (p.in_seepage[a] == 0)
      source[a] += std::clamp(0.5 * interval * (velocity_gradient[a] * velocity_gradient[a]).trace(),
                              -motion::most_strain / interval, motion::most_strain / interval);
  });
  if (setup.responds) p.spreading = std::move(spreading);
  if (!setup.responds || state.last_interval <= 0.0) return source;
  const auto unseen = unseen_strain_rate<D>(state, s, view, interval);
  for (std::size_t a = 0; a < p.size(); ++a) source[a] -= moves_with_soil(setup, state, view, a) * unseen[a];
  return source;
}

template <int D>
VecArray<D> deferred_flux(const Setup<D>& setup, State<D>& state, const SoilView<D>& view, double interval) {
  auto& p = state.particles;
  if (!setup.responds || state.last_interval <= 0.0) return {};
  const double came = state.last_interval, due = std::max(state.deferred_motion_due, interval);
  state.deferred_motion_due = std::max({0.0, state.deferred_motion_due - interval, came - interval});
  if (!p.deferred_motion.is_allocated()) p.deferred_motion.allocate(p.size());
  VecArray<D> deferred(p.size(), Vec<D>::Zero());
  parallel_for(p.size(), [&](std::size_t a) {
    Vec<D> motion = Vec<D>::Zero();
    if (view.fraction[a] > 0.0)
      motion = came * moves_with_soil(setup, state, view, a) * (view.mean_velocity[a] - p.solid_velocity[a]);
    deferred[a] = motion / std::max(interval, came) + p.deferred_motion[a] / due;
    p.deferred_motion.set(a, p.deferred_motion[a] + (motion - interval * deferred[a]));
  });
  return deferred;
}

template <int D>
VecArray<D> catch_up(const Setup<D>& setup, const SoilView<D>& view, std::span<const Vec<D>> deferred, double interval,
                     const State<D>& state) {
  if (deferred.empty() || setup.computes_beside) return {};
  const auto& p = state.particles;
  VecArray<D> behind(p.size(), Vec<D>::Zero());
  parallel_for(p.size(), [&](std::size_t a) {
    const double with_soil = moves_with_soil(setup, state, view, a), n_s = view.fraction[a];
    if (with_soil > 0.0) behind[a] = interval * (1.0 - n_s / with_soil) / p.void_fraction[a] * deferred[a];
  });
  return behind;
}

/// In saturated soil at rest, displacements without net volume repair the packing, so that no water passes a face. A
/// repair by pressure would press water out without end where points are disordered, since their sum V W exceeds that
/// of a lattice; and the pressure that moves water in one soil would act in all others.
template <int D>
VecArray<D> repair(const Setup<D>& setup, const State<D>& state, const Stencil<D>& s, const SoilView<D>& view,
                   double interval) {
  const auto& p = state.particles;
  if (!state.full) return {};
  const auto motion = moved<D>(state.particles);
  ScalarArray share(p.size()), expansion(p.size());
  parallel_for(p.size(), [&](std::size_t a) {
    share[a] = motion[a] * interval / repair_time<D>(setup, state.particles, a, view, interval);
    expansion[a] = packing_error<D>(setup, state.particles, s, a, s.fullness[a]);
  });
  // Separate bodies of water exchange no volume.
  const auto body = bodies_of<D>(s, p.share.ids);
  ScalarArray all(body.count, 0.0), made(body.count, 0.0);  // sums over each body
  for (std::size_t a = 0; a < p.size(); ++a) {
    const auto b = static_cast<std::size_t>(body.of[a]);
    all[b] += p.volume[a] * share[a];
    made[b] += p.volume[a] * share[a] * expansion[a];
  }
  for (auto* sums : {&all, &made}) s.domain.sum(*sums);
  parallel_for(p.size(), [&](std::size_t a) {
    const auto b = static_cast<std::size_t>(body.of[a]);
    expansion[a] = share[a] * (expansion[a] - (all[b] > 0.0 ? made[b] / all[b] : 0.0));
  });
  return expand<D>(s, expansion);
}

#define PORETWIN_INSTANTIATE(D)                                                                                      \
  template bool uses_density_weight(const Setup<D>&);                                                                \
  template ScalarArray moved(const Particles<D>&);                                                                   \
  template double free_repair_time(const Setup<D>&, double);                                                         \
  template double repair_time(const Setup<D>&, const Particles<D>&, std::size_t, const SoilView<D>&, double);        \
  template double packing_error(const Setup<D>&, const Particles<D>&, const Stencil<D>&, std::size_t, double, bool); \
  template ScalarArray volume_source(const Setup<D>&, State<D>&, const Stencil<D>&, const SoilView<D>&,              \
                                     std::span<const Mat<D>>, double);                                               \
  template VecArray<D> deferred_flux(const Setup<D>&, State<D>&, const SoilView<D>&, double);                        \
  template VecArray<D> catch_up(const Setup<D>&, const SoilView<D>&, std::span<const Vec<D>>, double,                \
                                const State<D>&);                                                                    \
  template VecArray<D> repair(const Setup<D>&, const State<D>&, const Stencil<D>&, const SoilView<D>&, double);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::fluid
