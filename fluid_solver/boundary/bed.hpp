// Walls that let water through: the bed between free water and the ground, which another solver computes.
//
// A finite volume beside the bed loses the flow q through the bed's face:
//
//   dV/dt = V div v = - q A,  q: into the ground
//
// with v parallel to the bed on it. So the particles before the bed shrink by what the ground takes, and grow by what
// it gives; the pressure solve gets the same term as a source, smoothed as the divergence is. Mass is conserved to
// rounding whatever the arrangement of the particles. Small particles merge with a neighbour, large ones divide.
//
// Between the two solvers stands a film on each part of the bed: water that the ground has given and the particles have
// not taken yet; negative where the ground has taken more than the particles have given.
#pragma once

#include "fluid_solver/boundary/walls.hpp"
#include "fluid_solver/state.hpp"

#include <span>

namespace poretwin::fluid {

/// Free water before a part of the bed.
struct BedWater {
  double head = 0.0;  ///< m, mean pressure head at its centre since the last turn_over(); zero or below: it is dry
  /// m^D, of the particles in its reach, if it is wet; each is shared among all wet parts in whose reach it lies.
  double volume = 0.0;
};

/// What passes the bed in a window.
struct BedPassage {
  ScalarArray gained;  ///< [particles] m^D
  ScalarArray given;   ///< [parts] m^D, from the film to the particles
};

/// Adds the pressure at the window's start to the means of the heads, and finds what passes in the window of
/// `interval` [s] at the parts' rates.
template <int D>
BedPassage pass_bed(const Setup<D>& setup, double interval, State<D>& state);

/// Adds to the volume source [1/s] what passes: the mean growth around each particle, with the weights V W.
///
/// The sums over pairs show the divergence of the water smoothed by the kernel (sum V v . grad W is the divergence of
/// sum V v W). So the velocity that makes room for each particle's own growth has the smoothed growth as its
/// divergence. With the growth itself as the source, rows above those that grow are lifted too far: the level of a pond
/// that rises is up to half a spacing too high.
template <int D>
void add_bed_source(const BedPassage& passage, double interval, const Stencil<D>& s, std::span<double> source);

/// Changes the particles' volumes and the films.
template <int D>
void change_volumes(const Setup<D>& setup, const BedPassage& passage, State<D>& state);

/// Merges particles that have become small, divides large ones, makes and removes particles on the bed. It changes
/// which particles there are, so that it comes last in a window.
template <int D>
void even_volumes(const Setup<D>& setup, const Walls<D>& walls, State<D>& state);

/// The water before each part now.
template <int D>
std::vector<BedWater> water_before_bed(const Setup<D>& setup, const State<D>& state);

/// Sets the films [m^D], which turn into particles over the next `within` [s], and begins the means of the heads anew.
template <int D>
void turn_over(std::span<const double> film, double within, State<D>& state);

}  // namespace poretwin::fluid
