// Where the water ends: walls, pistons and periodic sides as mirrors, and what can be seen past them.
#pragma once

#include "fluid_solver/boundary/inlet.hpp"

#include <memory>

namespace poretwin {
class Surfaces;
}

namespace poretwin::fluid {

/// The walls, pistons (where they stand at first) and periodic sides of the water as mirrors. Pieces that end where no
/// other begins, or in a corner of less than 180 degrees, go on for `margin` [m], to fill the corner.
template <int D>
std::vector<sph::ImagePlane<D>> water_planes(const Case& scene, const std::vector<Inlet<D>>& inlets, double margin);

/// What the water sees past its walls, and the mirrors it sees them as, where that matters (`sight_matters`); nothing
/// otherwise. Walls end where they are drawn, but at a water face, behind which they go on for `margin` [m].
template <int D>
sph::Sight<D> water_sight(const Case& scene, double margin);

/// The walls of the water, if one of them at least has a shape (3D); nothing otherwise.
std::shared_ptr<const Surfaces> water_surfaces(const Case& scene);

template <int D>
struct Walls {
  Walls(const Case& scene, const std::vector<Inlet<D>>& inlets);

  /// Moves the pistons to where they stand.
  void place(const std::vector<Inlet<D>>& inlets);

  /// Throws CaseError if one of the points [m] lies behind a wall with a shape.
  void expect_before(std::span<const Vec<D>> points) const;

  std::vector<sph::ImagePlane<D>> planes;
  sph::Sight<D> sight;
  std::shared_ptr<const Surfaces> surfaces;  ///< of walls, the planes among them too, if any wall has a shape (3D)

 private:
  std::vector<sph::ImagePlane<D>> at_first_;  ///< but those of sills
  double margin_ = 0.0;                       ///< m
};

}  // namespace poretwin::fluid
