// Even spacing of the particles: shifting along the gradient of concentration, and separation of pairs of particles
// that come too close.
#pragma once

#include "common/core/threads.hpp"
#include "fluid_solver/discretisation/free_surface.hpp"
#include "fluid_solver/discretisation/operators.hpp"
#include "fluid_solver/discretisation/stencil.hpp"
#include "fluid_solver/numerics/motion.hpp"

namespace poretwin::fluid {

/// Displacement by shifting: per speed times dt h, and per h^2. Separation below which pairs are pushed apart, in
/// spacings.
struct PackingLaw {
  double by_speed, by_length, closest;
};
inline constexpr PackingLaw packing_in_soil{motion::shift_by_speed_in_soil, motion::shift_by_length,
                                            motion::closest_in_soil},
    packing_in_free_water{motion::shift_by_speed_in_free_water, motion::shift_by_length, motion::closest_in_free_water},
    packing_in_full_soil{motion::shift_by_speed_in_full_soil, motion::shift_by_length, motion::closest_in_soil};

/// Displacements [m] that even out the packing. speed [m/s]: in soil relative to the soil. moved[a] in [0, 1] scales
/// the displacement (0: at rest, needs no repair). Shifting follows the gradient of concentration (after Lind et al.
/// 2012); near the surface only its component along the surface is used.
template <int D>
VecArray<D> packing_displacements(const Stencil<D>& s, std::span<const double> speed, std::span<const double> moved,
                                  std::span<const Surface> flags, std::span<const char> in_seepage, double interval,
                                  bool full = false) {
  VecArray<D> shift(s.n_real, Vec<D>::Zero());
  parallel_for(s.n_real, [&](std::size_t a) {
    if (moved[a] == 0.0 || flags[a] == Surface::lone) return;
    const PackingLaw& law = in_seepage[a] == 0 ? packing_in_free_water : full ? packing_in_full_soil : packing_in_soil;
    const double h = s.length(a), spacing = h / points::smoothing_ratio;
    // sum V grad W is zero in even surroundings; elsewhere it points towards more particles.
    Vec<D> d = -(law.by_speed * h * speed[a] * interval + law.by_length * h * h) * s.normal[a];
    if (flags[a] == Surface::surface || s.ghost_distance[a] > 0.0) {
      const Vec<D> normal = s.normal[a].normalized();
      d -= normal.dot(d) * normal;
    }
    const bool crowded = s.closest[a] * points::smoothing_ratio < law.closest;
    for (Index k = s.offset[a]; crowded && k < s.offset[a + 1]; ++k) {
      const Index j = s.other[k];
      const Vec<D> ba = s.position[j] - s.position[a];
      const double r2 = ba.squaredNorm(), limit = law.closest * 0.5 * (h + s.length(j)) / points::smoothing_ratio;
      if (r2 >= limit * limit || r2 == 0.0) continue;
      const double r = std::sqrt(r2);
      d -= motion::push * (limit - r) / r * ba;
    }
    const double length = d.norm(), most = motion::longest_shift * spacing;
    if (length > most) d *= most / length;
    shift[a] = moved[a] * d;
  });
  return shift;
}

/// Displacements [m] by which each particle's bulk volume expands by the fraction expansion [n] (the sum of V expansion
/// is zero), in water that fills the whole domain. They are the gradient of a potential, with div d = expansion and no
/// flow through walls and faces. They do not depend on the soils' conductivity: they even out the points, and no
/// pressure is needed to drive them. All ranks call this.
template <int D>
VecArray<D> expand(const Stencil<D>& s, std::span<const double> expansion) {
  auto matrix = laplacian<D>(s, {});
  ScalarArray b(s.n_real), inverse(s.n_real), potential(s.n_real, 0.0);
  parallel_for(s.n_real, [&](std::size_t a) {
    double sum = 0.0;  // without the faces
    for (std::size_t k = matrix.begin(a); k < matrix.end(a); ++k) sum += static_cast<double>(matrix.weight[k]);
    matrix.diagonal[a] = sum;
    inverse[a] = sum > 0.0 ? 1.0 / sum : 0.0;
    b[a] = -s.volume[a] * expansion[a];
  });
  const auto apply = [&](std::span<const double> x, std::span<double> y) { matrix.apply(x, y); };
  const auto precondition = [&](std::span<const double> r, std::span<double> z) {
    parallel_for(s.n_real, [&](std::size_t a) { z[a] = inverse[a] * r[a]; });
  };
  const double size = s.domain.norm(b);
  if (size > 0.0)
    conjugate_gradients(s.domain, apply, precondition, b, potential, motion::repair_tolerance * size,
                        motion::most_repair_iterations);
  const auto potentials = s.template with_copies<double>(potential);
  VecArray<D> displacement(s.n_real);
  parallel_for(s.n_real, [&](std::size_t a) {
    Vec<D> sum = Vec<D>::Zero();
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
      const Index j = s.other[k], q = s.parent[j];
      if (q < s.n_particles)
        sum += static_cast<double>(s.gradient_factor[k]) * (potentials[q] - potentials[a]) *
               (s.position[j] - s.position[a]);
    }
    displacement[a] = s.correction_open(a) * sum;
  });
  return displacement;
}

}  // namespace poretwin::fluid
