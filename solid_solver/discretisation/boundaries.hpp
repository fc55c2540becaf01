// Walls and periodic sides of the soil: planes and surfaces that make images, and the rules by which images follow
// their parents.
#pragma once

#include "common/geometry/shapes.hpp"
#include "common/geometry/surfaces.hpp"
#include "common/particles/sight.hpp"
#include "solid_solver/discretisation/operators.hpp"

#include <algorithm>
#include <memory>

namespace poretwin::solid {

template <int D>
struct Setup;

/// All walls and periodic sides that make images of the soil: planes, or surfaces in place of the planes.
template <int D>
struct Boundaries {
  using Kind = BoundaryKind;
  std::vector<sph::ImagePlane<D>> planes;    ///< plane k has boundary number k
  sph::Sight<D> sight;                       ///< lines of sight past thin walls, if the case has any (2D)
  std::shared_ptr<const Surfaces> surfaces;  ///< all walls, in place of planes, if any wall has a shape (3D)
  std::vector<Kind> kinds;                   ///< by boundary number
  ScalarArray friction;                      ///< Coulomb's friction coefficient, of frictional boundaries
  std::vector<int> plate;                    ///< number of the plate that a boundary is; -1: none
  std::vector<char> tilts;                   ///< 1 where a boundary is a plate that tilts, by boundary number
  [[nodiscard]] bool any_frictional() const {
    return std::find(kinds.begin(), kinds.end(), Kind::frictional) != kinds.end();
  }
};

/// Boundaries from the case's walls and periodic axes. margin [m]: length by which walls are extended beyond their
/// ends, so that corners are closed.
template <int D>
Boundaries<D> make_boundaries(const Case& scene, double margin);

/// The planes of a plate as drawn: a straight line (2D), a rectangle along the axes (3D), or a plane without ends.
template <int D>
std::vector<sph::ImagePlane<D>> plate_planes(const Plate& plate);

/// The boundaries with the plates at their present places. The planes of plates have the plates' speeds.
template <int D>
Boundaries<D> with_plates_at(const std::vector<PlateMotion<D>>& plates, Boundaries<D> boundaries);

/// Particles that have left through a periodic side re-enter through the opposite side.
template <int D>
void wrap_periodic(const Boundaries<D>& boundaries, VecArray<D>& positions);

/// Reflects particles that have passed through a wall since the lists were built, and removes their velocity towards
/// the wall. reach [m]: the largest distance in front of the wall at which they may lie afterwards.
template <int D>
void keep_before_walls(const Boundaries<D>& boundaries, double reach, const Neighbourhood<D>& near,
                       Particles<D>& particles);

/// Makes images and pair lists for the current positions. range [m]: kernel support plus skin; n_parts: parts of the
/// rows for threads; asleep: see pair_up.
template <int D>
void build_neighbourhood(const Boundaries<D>& boundaries, double range, std::size_t n_parts,
                         const Particles<D>& particles, std::span<const char> asleep, Neighbourhood<D>& near);

/// Sets position, velocity, gradient, flux and hourglass level of the nodes, including copies of other ranks' particles
/// and images. Brings what images of the copies need (velocity, displacement, slip, stress, plastic strain, body force)
/// up to date.
template <int D>
void fill_nodes(const Setup<D>& setup, State<D>& state);

/// Sets only the velocities, between the two halves of a step.
template <int D>
void fill_velocities(const Setup<D>& setup, State<D>& state);

}  // namespace poretwin::solid
