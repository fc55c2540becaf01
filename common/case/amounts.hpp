// The size of a run of a case, estimated from areas and volumes before any particle is made.
#pragma once

#include "common/case/case.hpp"

namespace poretwin {

/// Area (2D) or volume (3D) of a shape [m^D].
double measure(const Shape& shape, int dimension);

/// Estimated numbers of particles, frames and readings of a run, and its memory; zero for a phase that the run lacks.
struct Amounts {
  double fluid = 0.0, solid = 0.0;  ///< particles at time zero
  double fluid_full = 0.0;          ///< water particles once all soil is saturated, where faces let water in
  double frames = 0.0;
  double frame_bytes = 0.0;   ///< all frames together
  double gauge_rows = 0.0;    ///< rows of gauges.csv; 0 where gauges are read at every exchange, since the number of
                              ///< exchanges is unknown
  double memory_bytes = 0.0;  ///< all processes together
};
Amounts estimate(const Case& scene);

/// The finest particle spacing of the phases that run [m].
double finest_spacing(const Case& scene);

/// Lattice spacing for tests that examine a whole shape: the given spacing, or a coarser one if the box around the
/// shape would contain more than 1e5 points.
double spacing_to_look_at(const Shape& shape, double spacing, int dimension);

/// Places spread over a shape, that lattice spacing apart.
std::vector<Point3> places_in(const Shape& shape, double spacing, int dimension);

}  // namespace poretwin
