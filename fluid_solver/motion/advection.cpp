#include "fluid_solver/motion/advection.hpp"

#include "common/core/threads.hpp"
#include "common/geometry/surfaces.hpp"
#include "fluid_solver/motion/collisions.hpp"
#include "fluid_solver/motion/packing.hpp"
#include "fluid_solver/motion/volume_source.hpp"
#include "fluid_solver/numerics/motion.hpp"

#include <cmath>

namespace poretwin::fluid {

namespace {

/// Displacement in a window of the surface, half a spacing outside its particles, beyond that of these particles.
/// Without it waves are too slow, in proportion to the ratio of that half spacing to their depth of decay (1.8 % at 50
/// particles per wavelength), and a front lags by half a spacing.
///
/// growth [1/s]: rate at which water comes into the particle's own volume. It moves the surface away from the particle,
/// and not the particle to the surface.
template <int D>
Vec<D> surface_lead(const Mat<D>& velocity_gradient, double growth, const Vec<D>& inward, double distance,
                    double interval) {
  const Vec<D> n = inward.normalized();
  const double stretching = std::clamp(n.dot(velocity_gradient * n) - growth, -motion::most_strain / interval,
                                       motion::most_strain / interval);
  return -distance * stretching * n;
}

template <int D>
void displace(const Setup<D>& setup, const Walls<D>& walls, Particles<D>& p, std::size_t a, const Vec<D>& d,
              bool stop_at_walls) {
  const Vec<D> before = p.position[a];
  p.position[a] += d;
  Vec<D> v = p.velocity[a];
  keep_inside<D>(walls, before, spacing_of<D>(p.volume[a]), p.position[a], v);
  if (stop_at_walls) p.velocity[a] = v;
  for (const int axis : setup.periodic) {
    const double lower = setup.periodic_lower[axis], length = setup.periodic_length[axis];
    const double wrapped = p.position[a][axis] - length * std::floor((p.position[a][axis] - lower) / length);
    p.birthplace[a][axis] += wrapped - p.position[a][axis];
    p.position[a][axis] = wrapped;
  }
}

}  // namespace

template <int D>
void keep_inside(const Walls<D>& walls, const Vec<D>& before, double spacing, Vec<D>& x, Vec<D>& v) {
  if constexpr (D == 3)
    if (walls.surfaces) walls.surfaces->keep_inside(before, spacing, x, v);
  if (walls.sight.limited())
    walls.sight.keep_inside(before, x, v);
  else
    sph::keep_inside<D>(walls.planes, spacing, x, v);
}

/// Free water moves half a window before the solve and half a window after it (leapfrog). This is of second order and
/// has no damping of its own.
template <int D>
void drift(const Setup<D>& setup, const Walls<D>& walls, double interval, Particles<D>& p) {
  parallel_for(p.size(), [&](std::size_t a) {
    if (p.in_seepage[a] == 0) displace<D>(setup, walls, p, a, 0.5 * interval * p.velocity[a], false);
  });
}

template <int D>
void move(const Setup<D>& setup, const Walls<D>& walls, const Stencil<D>& s, const WindowSolution<D>& solution,
          std::span<const Mat<D>> velocity_gradient, std::span<const Vec<D>> velocity_before,
          std::span<const Vec<D>> besides, std::span<const double> gained, double interval, State<D>& state) {
  auto& p = state.particles;
  // Water in soil that moves as a whole keeps its packing: only motion of the water through the soil disorders it.
  auto motion = moved<D>(state.particles);
  ScalarArray speed(p.size());
  parallel_for(p.size(), [&](std::size_t a) {
    speed[a] = (p.velocity[a] - p.mask[a] * p.solid_velocity[a]).norm();
    motion[a] *= std::min(1.0, speed[a] * interval / (motion::shifts_from * spacing_of<D>(p.volume[a])));
  });
  auto shift = packing_displacements<D>(s, speed, motion, p.surface, p.in_seepage, interval, state.full);
  parallel_for(besides.size(), [&](std::size_t a) { shift[a] += besides[a]; });
  collide(setup, s, p);
  parallel_for(p.size(), [&](std::size_t a) {
    Vec<D> d = interval * p.velocity[a];
    if (p.in_seepage[a] != 0)
      d += interval * look_ahead(state.last_interval, interval) * (p.velocity[a] - velocity_before[a]);
    else
      d *= 0.5;
    d += shift[a];
    if (p.in_seepage[a] == 0 && p.surface[a] == Surface::surface) {
      const double growth = gained.empty() ? 0.0 : gained[a] / (p.volume[a] * interval);
      d += interval * surface_lead<D>(velocity_gradient[a], growth, s.normal[a], s.surface_distance(a), interval);
    }
    const double before = p.pressure[a] + setup.weight.dot(p.position[a] - setup.origin);
    p.pressure[a] += solution.gradient[a].dot(p.in_seepage[a] != 0 ? d : shift[a]);
    // A shifted particle takes the velocity that the water has where the particle arrives.
    if (p.in_seepage[a] == 0 && s.ghost_distance[a] == 0.0 && p.surface[a] == Surface::interior)
      p.velocity[a] += velocity_gradient[a] * shift[a];
    displace<D>(setup, walls, p, a, d, true);
    // Seeping water that reaches its surface takes the surface's pressure, not one extrapolated beyond it.
    if (p.in_seepage[a] != 0 && p.surface[a] != Surface::interior)
      p.pressure[a] = std::max(
          p.pressure[a], std::min(before, s.surface_pressure[a]) - setup.weight.dot(p.position[a] - setup.origin));
  });
}

#define PORETWIN_INSTANTIATE(D)                                                                     \
  template void keep_inside(const Walls<D>&, const Vec<D>&, double, Vec<D>&, Vec<D>&);              \
  template void drift(const Setup<D>&, const Walls<D>&, double, Particles<D>&);                     \
  template void move(const Setup<D>&, const Walls<D>&, const Stencil<D>&, const WindowSolution<D>&, \
                     std::span<const Mat<D>>, std::span<const Vec<D>>, std::span<const Vec<D>>,     \
                     std::span<const double>, double, State<D>&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::fluid
