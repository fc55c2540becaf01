// Erosion: free water that runs over the soil carries its surface off, grain by grain.
#pragma once

#include "solid_solver/setup.hpp"
#include "solid_solver/state.hpp"

namespace poretwin::solid {

/// The part of the soil's surface that belongs to one particle.
template <int D>
struct SurfacePart {
  Vec<D> normal = Vec<D>::Zero();  ///< unit, into the soil
  double per_volume = 0.0;         ///< 1/m, its area over the particle's volume
  double coverage = 0.0;           ///< by soil, sum V W with the particle itself
};

/// The soil's surface at every particle: direction and length of sum_j V_j grad W_ij, the gradient of the coverage. The
/// lengths are scaled so that the parts of a flat edge along the lattice have the edge's area. Images behind walls
/// count as soil. Inside the soil the sum is zero, but for some hundredths in disordered soil.
template <int D>
std::vector<SurfacePart<D>> surface_parts(const Setup<D>& setup, const State<D>& state);

/// Erodes the soil for a window's length [s]: at every particle the erosion law of its soil gives the speed of the
/// surface under the shear stress of the free water there, and that speed times the particle's part of the surface is
/// the volume that it loses per time. A particle that has lost its whole volume leaves the soil, and so does one by
/// itself where anything erodes: its grains count as carried off, with their momentum and what the particle holds for
/// the water. Others keep their state. velocity: of
/// the free water at the particles [m/s], components consecutive; 0 without free water.
template <int D>
void erode(const Setup<D>& setup, double interval, const OrZero<double>& velocity, State<D>& state);

}  // namespace poretwin::solid
