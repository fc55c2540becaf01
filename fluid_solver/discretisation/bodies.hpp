// Bodies of water: particles that touch one another, directly or through others.
#pragma once

#include "fluid_solver/state.hpp"

#include <span>
#include <vector>

namespace poretwin::fluid {

/// The number of the body of water to which each particle at x belongs, from 0. counts [n]: 1 for particles that count,
/// 0 for others, which get -1. Particles touch within motion::touching spacings. spacing: m.
template <int D>
std::vector<int> bodies_of(std::span<const Vec<D>> x, std::span<const char> counts, double spacing);

/// As above, for all real particles of a stencil. Particles touch where they are in each other's rows.
template <int D>
std::vector<int> bodies_of(const Stencil<D>& s);

/// Raises the wave speed of each particle to that of long waves on its body of water, sqrt(g depth), or of a drop in
/// the central force. body: from bodies_of.
template <int D>
void raise_wave_speeds(const Setup<D>& setup, std::span<const int> body, Particles<D>& p);

/// Sets the properties that particles and columns keep from the body of water in which they begin: the speed of its
/// waves, and whether it goes with the soil. A body goes with the soil if all of it lies in soil that can leave its
/// place and a face lies on that soil.
template <int D>
void begin_bodies(const Setup<D>& setup, State<D>& state);

/// Numbers the bodies of water that only walls surround: no surface has been found in such a body, and no face or inlet
/// touches it. All ranks call this; a body that lies on several of them has one number.
template <int D>
void number_closed_bodies(const Stencil<D>& s, State<D>& state);

}  // namespace poretwin::fluid
