// The free surface: which particles lie on it, how far it is from the other particles, and its terms in the equations
// for the pressure.
#pragma once

#include "common/core/threads.hpp"
#include "fluid_solver/discretisation/stencil.hpp"
#include "fluid_solver/numerics/surface.hpp"

#include <algorithm>
#include <cstdint>
#include <numbers>

namespace poretwin::fluid {

enum class Surface : std::uint8_t { interior, surface, lone };

/// Thickness of the row of surface particles at particle a, over that of a lattice. The surface lies half of it above
/// the row. In a tank at rest, particles join the row and make it up to 15 % thicker. With a surface fixed at half a
/// spacing above the row, the pressure would fall in a minute by 0.3 % of that of a depth of 20 spacings.
template <int D>
double row_thickness(const Stencil<D>& s, std::size_t a) {
  static const double lattice = [] {
    const auto part = [](double r) { return Kernel<D>::value(r, points::smoothing_ratio); };
    if constexpr (D == 3) return lattice_sum<2>(part);
    double sum = part(0.0);
    for (int i = 1; i <= 3; ++i) sum += 2.0 * part(1.0 * i);
    return sum;
  }();
  const double h = s.length(a), spacing = h / points::smoothing_ratio;
  const Vec<D> n = s.normal[a].normalized();
  double sum = Kernel<D>::value(0.0, h);
  Vec<D> centre = Vec<D>::Zero();
  for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
    const Index j = s.other[k];
    if (s.on_surface[j] != 1) continue;
    const Vec<D> d = s.position[j] - s.position[a];
    const double out = n.dot(d);
    if (std::abs(out) > 0.5 * spacing) continue;
    const double value = s.value(a, j);
    sum += value;
    centre += value * (d - out * n);
  }
  const double thickness = sum * std::pow(spacing, D) / lattice;
  if (centre.norm() > surface::balanced_row * h * sum || std::abs(thickness - 1.0) > surface::uneven_row) return 1.0;
  return thickness;
}

/// The surface above particle a, from the surface particles of its own kind within reach. Members: sums, weighted with
/// W, of the outward normal, the surface's height above the particle along it [m], and the surface's pressure [Pa].
template <int D>
struct SurfacePlane {
  double weight = 0.0, height = 0.0, pressure = 0.0;
  Vec<D> normal = Vec<D>::Zero();
};
template <int D>
SurfacePlane<D> surface_plane(const Stencil<D>& s, std::size_t a, bool in_seepage) {
  SurfacePlane<D> plane;
  const char own_kind = in_seepage ? 2 : 1;
  for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
    const Index j = s.other[k], q = s.parent[j];
    if (s.on_surface[j] != own_kind) continue;
    Vec<D> n = -s.normal[q].normalized();
    if (j >= s.n_base) n = s.map[j - s.n_base] * n;
    const double value = s.value(a, j);
    plane.weight += value;
    plane.normal += value * n;
    plane.pressure += value * s.surface_pressure[q];
    plane.height += value * (n.dot(s.position[j] - s.position[a]) + s.surface_distance(q));
  }
  return plane;
}

/// Depth of particle a of free water below the surface [m]; 0 where the surface is beyond the reach of the particle's
/// kernel or is not a plane.
template <int D>
double depth(const Stencil<D>& s, std::size_t a) {
  if (s.ghost_distance[a] > 0.0) return s.ghost_distance[a];
  const auto plane = surface_plane<D>(s, a, false);
  if (plane.normal.norm() <= surface::plane_enough * plane.weight) return 0.0;
  return std::max(plane.height / plane.weight, s.surface_distance(a));
}

/// Finds the surface particles and sets the surface's terms in the stencil.
///
/// In free water a particle lies on the surface by two criteria: the smallest eigenvalue of its moment matrix, and an
/// empty cone around the outward normal (Marrone et al. 2010). In soil, at a wetting front, it does so by the deficit
/// of the divergence of position (Lee et al. 2008), where no water stands opposite. If a hole under pressure counted as
/// a surface, it would draw in the water of a reservoir with its full head.
///
/// rows: thickness of the row in which each particle lies, in spacings, averaged over time. `share` is the weight of
/// its present value. The weight is small because surface particles move with the surface while a row is stretched
/// (surface_lead). none: the domain contains no air, and holes are disorder.
template <int D>
std::vector<Surface> find_surface(Stencil<D>& s, std::span<const char> in_seepage, std::span<double> rows = {},
                                  double share = 0.0, bool none = false) {
  std::vector<Surface> flags(s.n_real, Surface::interior);
  if (none) {
    s.on_surface.assign(s.size(), 0);
    return flags;
  }
  const std::vector<char> seeps = s.flags_with_copies(in_seepage);
  const auto umbrella = [&](std::size_t a) {
    const double h = s.length(a);
    const Vec<D> n = -s.normal[a].normalized();
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
      const Vec<D> d = s.position[s.other[k]] - s.position[a];
      const double r = d.norm();
      if (r >= std::numbers::sqrt2 * h ? (d - h * n).norm() < h : d.dot(n) > surface::cone * r) return true;
    }
    return false;
  };
  // The surface in soil is rough on the scale of a spacing, so that only the narrow cone counts. At a seepage face the
  // water in the soil ends at the face, although some of it may already have passed the face. Hence only free water
  // that flows down the face counts as water in front.
  const auto opposite = [&](std::size_t a) {
    const Vec<D> n = -s.normal[a].normalized();
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
      const Index q = s.parent[s.other[k]];
      if (s.at_face[a] && (q >= s.n_particles || seeps[q] != 0)) continue;
      const Vec<D> d = s.position[s.other[k]] - s.position[a];
      if (d.dot(n) > surface::narrow_cone * d.norm()) return true;
    }
    return false;
  };
  parallel_for(s.n_real, [&](std::size_t a) {
    if (in_seepage[a] != 0) {
      const double few = s.at_face[a] ? surface::few_at_face : surface::few;
      s.covered[a] = s.divergence[a] < few * D && opposite(a);
      if (s.covered[a]) return;
      if (s.divergence[a] < surface::too_few * D)
        flags[a] = Surface::lone;
      else if (s.divergence[a] < few * D)
        flags[a] = Surface::surface;
      return;
    }
    if (s.least_moment[a] >= points::inside_moment) return;
    const double amount = s.normal[a].norm();
    const double few = s.open_water[a] == 0 ? surface::few : surface::few_in_open_water;
    const bool hole = s.divergence[a] < few * D && amount * s.length(a) > surface::hole * s.divergence[a];
    const bool edge =
        s.least_moment[a] >= surface::alone && (hole || (amount * s.length(a) > surface::first_row && !umbrella(a)));
    if (edge)
      flags[a] = Surface::surface;
    else if (s.divergence[a] < surface::too_few * D)
      flags[a] = Surface::lone;
  });
  for (std::size_t a = 0; a < s.n_real; ++a) {
    if (flags[a] != Surface::lone || in_seepage[a] != 0) continue;
    s.boundary_correction(a).unresolved.setIdentity();
    s.correction[a].setZero();
  }
  ScalarArray own_kind(s.n_real);
  parallel_for(s.n_real, [&](std::size_t a) {
    own_kind[a] = flags[a] != Surface::surface ? 0.0 : in_seepage[a] == 0 ? 1.0 : 2.0;
  });
  const auto kind = s.template with_copies<double>(own_kind);
  s.on_surface.resize(s.size());
  parallel_for(s.size(), [&](std::size_t j) {
    const Index q = s.parent[j];
    s.on_surface[j] = q >= s.n_particles ? char{0} : static_cast<char>(kind[q]);
  });
  for (std::size_t a = 0; a < rows.size(); ++a) {
    const bool in_row = flags[a] == Surface::surface && in_seepage[a] == 0;
    rows[a] += share * ((in_row ? row_thickness<D>(s, a) : 1.0) - rows[a]);
    if (in_row) s.prescribed_surface_distance.set(a, s.surface_distance(a) * rows[a], s.n_particles);
  }
  s.fill_copies(s.prescribed_surface_distance);
  // For a particle below the surface: its distance from the plane through the surface particles of its own kind within
  // reach, and the surface's pressure. The distance is 0 where no such plane is found.
  const auto below = [&](std::size_t a) -> std::pair<double, double> {
    const auto plane = surface_plane<D>(s, a, in_seepage[a] != 0);
    if (plane.weight == 0.0 || plane.normal.isZero(0.0)) return {};
    const double cosine = -plane.normal.dot(s.normal[a]) / (plane.normal.norm() * s.normal[a].norm());
    if (cosine < surface::faces_plane) return {};
    const double distance = plane.height / (plane.weight * cosine);
    if (distance <= 0.0 || distance >= sph::support_radius * s.length(a)) return {};
    return {std::max(distance, s.surface_distance(a)), plane.pressure / plane.weight};
  };
  // Beside free water the gradient of seeping water does not include the surface: the rows of particles that touch free
  // water are not changed.
  const auto seeps_all_around = [&](std::size_t a) {
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k)
      if (const Index q = s.parent[s.other[k]]; q < s.n_particles && seeps[q] == 0) return false;
    return true;
  };
  std::vector<char> near(s.n_real);
  parallel_for(s.n_real, [&](std::size_t a) {
    near[a] = flags[a] != Surface::lone && s.normal[a].norm() * s.length(a) > surface::second_row;
  });
  for (std::size_t a = 0; a < s.n_real; ++a) {
    if (!near[a]) continue;
    if (in_seepage[a] != 0) {
      if (!seeps_all_around(a)) continue;
      if (flags[a] == Surface::interior && !s.covered[a])
        if (const auto [distance, pressure] = below(a); distance > 0.0) {
          s.front_distance.set(a, distance, s.n_real);
          s.surface_pressure.set(a, pressure, s.n_particles);
        }
      if (flags[a] == Surface::surface || s.front_distance[a] > 0.0) s.amplification[a] = lattice_amplification<D>();
      continue;
    }
    const double distance = flags[a] == Surface::surface ? s.surface_distance(a) : below(a).first;
    if (distance == 0.0) continue;
    s.ghost_distance.set(a, distance, s.n_real);
    // The ghost, at twice the distance, completes the moment matrix.
    const double amount = s.normal[a].norm();
    const Vec<D> n = s.normal[a] / amount;
    Mat<D>& unresolved = s.boundary_correction(a).unresolved;
    s.correction[a] = bounded_inverse<D>(s.moment(a) + 2.0 * distance * amount * n * n.transpose(),
                                         surface::least_inverted, &unresolved);
  }
  // Inside the water, where neighbours are few, the pair sums of the Laplacian are too small, but the corrected
  // gradient is not. The pressure from this Laplacian, applied with this gradient, would correct the velocity more than
  // once. In soil drag keeps this effect small.
  parallel_for(s.n_real, [&](std::size_t a) {
    if (const double deficit = s.divergence[a] / D;
        in_seepage[a] == 0 && deficit < surface::few && flags[a] == Surface::interior && s.ghost_distance[a] == 0.0)
      s.amplification[a] = 1.0 / std::max(deficit, surface::least_inverted);
  });
  fill_copies(s.domain, std::span(s.amplification));
  return flags;
}

/// Term by which the total pressure of the surface, at a distance outside particle a, enters the matrix row of a:
/// coefficient * (ph_a - pressure).
struct SurfaceRow {
  double coefficient = 0.0;  ///< of the matrix row, which is weighted with the volume
  double pressure = 0.0;     ///< piezometric, Pa
};

/// The term for a surface that lies `distance` [m] outside the particle. weight: rho g [N/m3]; origin: the point at
/// which piezometric and total pressure are equal [m].
template <int D>
SurfaceRow surface_row(const Stencil<D>& s, std::size_t a, double distance, double mobility, const Vec<D>& weight,
                       const Vec<D>& origin) {
  const double amount = s.normal[a].norm();
  if (amount == 0.0) return {};
  const Vec<D> x = s.position[a] - distance / amount * s.normal[a];
  return {s.volume[a] * 2.0 * mobility * amount / distance, s.surface_pressure[a] - weight.dot(x - origin)};
}

}  // namespace poretwin::fluid
