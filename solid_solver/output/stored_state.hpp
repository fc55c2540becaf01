// The soil as a frame of a run holds it.
#pragma once

#include "common/output/frame_file.hpp"
#include "solid_solver/setup.hpp"

namespace poretwin::solid {

template <int D>
struct StoredState {
  State<D> state;     ///< at rest, as far as factor_of_safety() needs it
  VecArray<D> water;  ///< N, force of the pore water on each particle
};

/// The soil of one frame. initial: the same soil as the case lays it out (laid_out), whose order of particles the frame
/// has. origin: what the case adds to positions in frames [m]. Throws FileError where the frame has other particles, or
/// lacks a field. Soil with rows behind rough walls cannot be read: frames do not hold those.
template <int D>
StoredState<D> stored_state(const Setup<D>& setup, const State<D>& initial, const FrameFile& frames, std::size_t frame,
                            const Point3& origin);

}  // namespace poretwin::solid
