// Bodies of water: particles that touch one another, directly or through others.
#pragma once

#include "fluid_solver/boundary/walls.hpp"
#include "fluid_solver/state.hpp"

#include <span>
#include <vector>

namespace poretwin::fluid {

/// The number of the body of water to which each particle at x belongs, from 0. counts [n]: 1 for particles that count,
/// 0 for others, which get -1. Particles touch within motion::touching spacings. spacing: m.
template <int D>
std::vector<int> bodies_of(std::span<const Vec<D>> x, std::span<const char> counts, double spacing);

/// The number of each real particle's body of water, from 0, and the number of bodies. Particles touch where they are
/// in each other's rows. All ranks call this; a body that lies on several of them has one number. ids [real]: of the
/// particles, where several ranks share the water.
struct NumberedBodies {
  std::vector<int> of;
  std::size_t count = 0;
};
template <int D>
NumberedBodies bodies_of(const Stencil<D>& s, std::span<const GlobalId> ids);

/// The extent of a body of water.
template <int D>
struct Extent {
  double top = -HUGE_VAL, bottom = HUGE_VAL;  ///< m, against gravity, of its particles' cells
  double farthest = 0.0;                      ///< m, distance of a particle from the origin
  Vec<D> lower = Vec<D>::Constant(HUGE_VAL), upper = Vec<D>::Constant(-HUGE_VAL);  ///< m, of its particles
};

/// The bodies of the particles that count, as in bodies_of, and the whole extent of each, on whichever ranks it lies.
/// All ranks call this.
template <int D>
struct MeasuredBodies {
  std::vector<int> of;
  std::vector<Extent<D>> extent;
};
template <int D>
MeasuredBodies<D> measured_bodies(const Setup<D>& setup, const Walls<D>& walls, const Particles<D>& p,
                                  std::span<const char> counts);

/// Raises the wave speed of each particle to that of long waves on its body of water, sqrt(g depth), or of a drop in
/// the central force.
template <int D>
void raise_wave_speeds(const Setup<D>& setup, const MeasuredBodies<D>& bodies, Particles<D>& p);

/// Sets the properties that particles and columns keep from the body of water in which they begin: the speed of its
/// waves, and whether it goes with the soil. A body goes with the soil if all of it lies in soil that can leave its
/// place and a face lies on that soil. Every rank has all water.
template <int D>
void begin_bodies(const Setup<D>& setup, State<D>& state);

/// Numbers the bodies of water that only walls surround: no surface has been found in such a body, and no face or inlet
/// touches it. All ranks call this; a body that lies on several of them has one number.
template <int D>
void number_closed_bodies(const Stencil<D>& s, State<D>& state);

}  // namespace poretwin::fluid
