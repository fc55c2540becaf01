// Mirrors that bound the water (walls, pistons, periodic sides), and lines of sight past them.
#pragma once

#include "fluid_solver/boundary/inlet.hpp"

#include <memory>

namespace poretwin {
class Surfaces;
}

namespace poretwin::fluid {

/// The walls, the pistons in their initial position, and the periodic sides of the water, as mirrors. A piece that ends
/// without a neighbour, or in a corner of less than 180 degrees, is extended by `margin` [m], which fills the corner.
template <int D>
std::vector<sph::ImagePlane<D>> water_planes(const Case& scene, const std::vector<Inlet<D>>& inlets, double margin);

/// Lines of sight past the walls and the mirrors along them, where they matter (`sight_matters`); empty otherwise.
/// Walls end where the case draws them, except at a water face, behind which they are extended by `margin` [m].
template <int D>
sph::Sight<D> water_sight(const Case& scene, double margin);

/// The walls of the water if at least one of them has a shape (3D); otherwise nothing.
std::shared_ptr<const Surfaces> water_surfaces(const Case& scene);

template <int D>
struct Walls {
  Walls(const Case& scene, const std::vector<Inlet<D>>& inlets);

  /// Moves the mirrors of the pistons to their present positions.
  void place(const std::vector<Inlet<D>>& inlets);

  /// Throws CaseError if one of the points [m] lies behind a wall with a shape.
  void expect_before(std::span<const Vec<D>> points) const;

  std::vector<sph::ImagePlane<D>> planes;
  sph::Sight<D> sight;
  std::shared_ptr<const Surfaces> surfaces;  ///< all walls, planes included, if any wall has a shape (3D)

 private:
  std::vector<sph::ImagePlane<D>> at_first_;  ///< mirrors in their initial position, without sills
  double margin_ = 0.0;                       ///< m, see water_planes()
};

}  // namespace poretwin::fluid
