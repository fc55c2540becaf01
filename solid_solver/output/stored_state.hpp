// The soil as a frame of a run stores it.
#pragma once

#include "common/output/frame_file.hpp"
#include "solid_solver/setup.hpp"

namespace poretwin::solid {

template <int D>
struct StoredState {
  State<D> state;     ///< at rest; the parts that factor_of_safety() needs
  VecArray<D> water;  ///< N, force of the pore water on each particle
};

/// The soil of one frame. initial: the soil as the case lays it out (laid_out), with the frame's order of particles.
/// origin: vector that the case adds to positions in frames [m]. Throws FileError where the frame has other particles
/// or lacks a field. Soil with rows behind rough walls cannot be read: frames do not contain them.
template <int D>
StoredState<D> stored_state(const Setup<D>& setup, const State<D>& initial, const FrameFile& frames, std::size_t frame,
                            const Point3& origin);

}  // namespace poretwin::solid
