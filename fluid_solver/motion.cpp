// How the water's particles move through one window, and what keeps them evenly spaced and inside the walls.
#include "fluid_solver/fluid_phase.hpp"

#include "fluid_solver/packing.hpp"

#include <cmath>

namespace poretwin::fluid {

namespace {

/// Displacement after which a particle's packing counts in full, in spacings.
constexpr double repair_displacement = 0.25;

}  // namespace

template <int D>
ScalarArray Fluid<D>::moved() const {
  const auto& p = state_.particles;
  ScalarArray result(p.size());
  for (std::size_t a = 0; a < p.size(); ++a) {
    const double spacing = std::pow(p.volume[a], 1.0 / D);
    result[a] = std::min(1.0, (p.position[a] - p.birthplace[a]).norm() / (repair_displacement * spacing));
  }
  return result;
}

/// Time in which a packing error is undone [s]: physical, not a number of windows. In soil, a third of what a unit
/// gradient needs to push water through one spacing; in free water twenty times that of a fall through one. Never less
/// than two windows: a repair that overtakes its window swings.
template <int D>
double Fluid<D>::repair_time(std::size_t a, const SoilView<D>& view, double interval) const {
  const double spacing = std::pow(state_.particles.volume[a], 1.0 / D);
  const double g = weight_.norm() > 0.0 ? weight_.norm() / density_ : 9.81;
  return std::max({2.0 * interval, 20.0 * std::sqrt(spacing / g),
                   0.3 * spacing * view.drag[a] / (density_ * g * state_.particles.void_fraction[a])});
}

/// Seepage is as slow or fast as its geometry makes it, and the window's velocity belongs to the geometry at its start:
/// motion extrapolates to the middle of the window (Adams-Bashforth of second order), in units of the last change of
/// velocity.
template <int D>
double Fluid<D>::look_ahead(double interval) const {
  return state_.last_interval > 0.0 ? std::min(1.0, 0.5 * interval / state_.last_interval) : 0.0;
}

template <int D>
void Fluid<D>::move(const Stencil<D>& s, const WindowSolution<D>& solution, std::span<const Vec<D>> velocity_before,
                    double interval) {
  auto& p = state_.particles;
  auto motion = moved();
  for (std::size_t a = 0; a < p.size(); ++a) {
    const double spacing = std::pow(p.volume[a], 1.0 / D);
    motion[a] *= std::min(1.0, p.velocity[a].norm() * interval / (0.02 * spacing));
  }
  const auto shift = packing_displacements<D>(s, p.velocity, motion, p.surface, interval);
  for (std::size_t a = 0; a < p.size(); ++a) {
    Vec<D> d = interval * p.velocity[a] + shift[a];
    if (p.mask[a] > 0.5) d += interval * look_ahead(interval) * (p.velocity[a] - velocity_before[a]);
    p.pressure[a] += solution.gradient[a].dot(d);
    p.position[a] += d;
    keep_inside(p.position[a], p.velocity[a], std::pow(p.volume[a], 1.0 / D));
    for (const int axis : scene_.general.periodic) {
      const double length = scene_.general.domain_max[axis] - scene_.general.domain_min[axis];
      const double wrapped = scene_.general.domain_min[axis] +
                             (p.position[a][axis] - scene_.general.domain_min[axis] -
                              length * std::floor((p.position[a][axis] - scene_.general.domain_min[axis]) / length));
      p.birthplace[a][axis] += wrapped - p.position[a][axis];
      p.position[a][axis] = wrapped;
    }
  }
}

/// A particle that slipped through a wall is mirrored back.
template <int D>
void Fluid<D>::keep_inside(Vec<D>& x, Vec<D>& v, double spacing) const {
  for (const auto& plane : planes_) {
    if (plane.kind != sph::ImagePlane<D>::Kind::mirror) continue;
    const double distance = plane.normal.dot(x - plane.point);
    if (distance >= 0.0 || distance < -spacing) continue;
    if (plane.to > plane.from) {
      const double along = plane.tangent.dot(x);
      if (along < plane.from || along > plane.to) continue;
    }
    x -= 2.0 * distance * plane.normal;
    v -= std::min(0.0, plane.normal.dot(v)) * plane.normal;
  }
}

template class Fluid<2>;
template class Fluid<3>;

}  // namespace poretwin::fluid
