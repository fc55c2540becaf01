// Where the water ends: walls, pistons and periodic sides as mirrors, and what can be seen past them.
#pragma once

#include "fluid_solver/boundary/inlet.hpp"

namespace poretwin::fluid {

/// The walls, pistons (where they stand at first) and periodic sides of the water as mirrors. Pieces that end where no
/// other begins, or in a corner of less than 180 degrees, go on for `margin` [m], to fill the corner.
template <int D>
std::vector<sph::ImagePlane<D>> water_planes(const Case& scene, const std::vector<Inlet<D>>& inlets, double margin);

/// What the water sees past its walls, and the mirrors it sees them as, where that matters (`sight_matters`); nothing
/// otherwise. Walls end where they are drawn, but at a water face, behind which they go on for `margin` [m].
template <int D>
sph::Sight<D> water_sight(const Case& scene, double margin);

template <int D>
struct Walls {
  Walls(const Case& scene, const std::vector<Inlet<D>>& inlets);

  /// Moves the pistons to where they stand.
  void place(const std::vector<Inlet<D>>& inlets);

  std::vector<sph::ImagePlane<D>> planes;
  sph::Sight<D> sight;

 private:
  std::vector<sph::ImagePlane<D>> at_first_;  ///< but those of sills
  double margin_ = 0.0;                       ///< m
};

}  // namespace poretwin::fluid
