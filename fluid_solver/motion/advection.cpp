// How the water's particles move through one window, and what keeps them evenly spaced and inside the walls.
#include "fluid_solver/fluid_phase.hpp"

#include "fluid_solver/motion/packing.hpp"
#include "fluid_solver/numerics/motion.hpp"

#include "common/core/threads.hpp"

#include <cmath>

namespace poretwin::fluid {

namespace {

/// What the surface, half a spacing outside its particles, moves faster than they do: without it a wave is slow by the
/// half spacing's share of its depth of decay (1.8 % at 50 particles a wave), and a front lags by half a spacing.
template <int D>
Vec<D> surface_lead(const Mat<D>& velocity_gradient, const Vec<D>& inward, double distance, double interval) {
  const Vec<D> n = inward.normalized();
  const double stretching =
      std::clamp(n.dot(velocity_gradient * n), -motion::most_strain / interval, motion::most_strain / interval);
  return -distance * stretching * n;
}

}  // namespace

template <int D>
double Fluid<D>::free_repair_time(double spacing) const {
  return motion::free_repair_falls * std::sqrt(spacing / gravity_or_standard_);
}

template <int D>
ScalarArray Fluid<D>::moved() const {
  const auto& p = state_.particles;
  ScalarArray result(p.size());
  parallel_for(p.size(), [&](std::size_t a) {
    const double spacing = spacing_of<D>(p.volume[a]);
    const double counts =
        (p.in_seepage[a] != 0 ? motion::repair_displacement : motion::free_repair_displacement) * spacing;
    result[a] = std::min(1.0, (p.position[a] - p.birthplace[a]).norm() / counts);
  });
  return result;
}

/// Time in which a packing error is undone [s]: physical, not a number of windows. In soil, a third of what a unit
/// gradient needs to push water through one spacing, and no longer than the flow takes to pass one: pair sums keep the
/// square of the concentration times the velocity, so that what is loose runs ahead and loosens as it goes. In free
/// water twenty times that of a fall through one spacing, or of the drag's where that is what holds the water. Never
/// less than two windows: a repair that overtakes its window swings.
template <int D>
double Fluid<D>::repair_time(std::size_t a, const SoilView<D>& view, double interval) const {
  const auto& p = state_.particles;
  const double spacing = spacing_of<D>(p.volume[a]), weight = density_ * gravity_or_standard_ * p.void_fraction[a];
  const double pushed = motion::pushed_repair * spacing * view.drag[a] / weight;
  const double passed = spacing / std::max(p.velocity[a].norm(), 1e-300);
  const double held =
      view.drag[a] > 0.0 ? motion::held_repair_times * p.void_fraction[a] * density_ / view.drag[a] : HUGE_VAL;
  return std::max(
      {motion::repair_windows * interval, std::min(free_repair_time(spacing), held), std::min(pushed, passed)});
}

/// Seepage is as slow or fast as its geometry makes it, and the window's velocity belongs to the geometry at its start:
/// motion extrapolates to the middle of the window (Adams-Bashforth of second order), in units of the last change of
/// velocity.
template <int D>
double Fluid<D>::look_ahead(double interval) const {
  return state_.last_interval > 0.0 ? std::min(1.0, 0.5 * interval / state_.last_interval) : 0.0;
}

/// Free water moves half a window before the solve and half after it (leapfrog): second order, no damping of its own.
template <int D>
void Fluid<D>::drift(double interval) {
  auto& p = state_.particles;
  parallel_for(p.size(), [&](std::size_t a) {
    if (p.in_seepage[a] == 0) displace(a, 0.5 * interval * p.velocity[a], false);
  });
}

template <int D>
void Fluid<D>::displace(std::size_t a, const Vec<D>& d, bool stop_at_walls) {
  auto& p = state_.particles;
  const auto& general = scene_.general;
  const Vec<D> before = p.position[a];
  p.position[a] += d;
  Vec<D> v = p.velocity[a];
  if (sight_.limited())
    sight_.keep_inside(before, p.position[a], v);
  else
    sph::keep_inside<D>(planes_, spacing_of<D>(p.volume[a]), p.position[a], v);
  if (stop_at_walls) p.velocity[a] = v;
  for (const int axis : general.periodic) {
    const double length = general.domain_max[axis] - general.domain_min[axis];
    const double wrapped =
        p.position[a][axis] - length * std::floor((p.position[a][axis] - general.domain_min[axis]) / length);
    p.birthplace[a][axis] += wrapped - p.position[a][axis];
    p.position[a][axis] = wrapped;
  }
}

template <int D>
void Fluid<D>::move(const Stencil<D>& s, const WindowSolution<D>& solution, std::span<const Mat<D>> velocity_gradient,
                    std::span<const Vec<D>> velocity_before, std::span<const Vec<D>> repair, double interval) {
  auto& p = state_.particles;
  auto motion = moved();
  parallel_for(p.size(), [&](std::size_t a) {
    const double spacing = spacing_of<D>(p.volume[a]);
    motion[a] *= std::min(1.0, p.velocity[a].norm() * interval / (motion::shifts_from * spacing));
  });
  auto shift = packing_displacements<D>(s, p.velocity, motion, p.surface, p.in_seepage, interval, state_.full);
  parallel_for(repair.size(), [&](std::size_t a) { shift[a] += repair[a]; });
  collide<D>(s, p.in_seepage, p.mass, p.velocity);
  parallel_for(p.size(), [&](std::size_t a) {
    Vec<D> d = interval * p.velocity[a];
    if (p.in_seepage[a] != 0)
      d += interval * look_ahead(interval) * (p.velocity[a] - velocity_before[a]);
    else
      d *= 0.5;
    d += shift[a];
    if (p.in_seepage[a] == 0 && p.surface[a] == Surface::surface)
      d += interval * surface_lead<D>(velocity_gradient[a], s.normal[a], s.surface_distance(a), interval);
    const double before = p.pressure[a] + weight_.dot(p.position[a] - origin_);
    p.pressure[a] += solution.gradient[a].dot(p.in_seepage[a] != 0 ? d : shift[a]);
    // What is shifted arrives where the water moves at another speed.
    if (p.in_seepage[a] == 0 && s.ghost_distance[a] == 0.0 && p.surface[a] == Surface::interior)
      p.velocity[a] += velocity_gradient[a] * shift[a];
    displace(a, d, true);
    // Water that seeps towards its surface arrives at the surface's pressure, not beyond it.
    if (p.in_seepage[a] != 0 && p.surface[a] != Surface::interior)
      p.pressure[a] =
          std::max(p.pressure[a], std::min(before, s.surface_pressure[a]) - weight_.dot(p.position[a] - origin_));
  });
}

template class Fluid<2>;
template class Fluid<3>;

}  // namespace poretwin::fluid
