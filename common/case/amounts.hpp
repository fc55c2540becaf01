// How much a case will be, estimated from areas and volumes before anything is made.
#pragma once

#include "common/case/case.hpp"

namespace poretwin {

/// Area (2D) or volume (3D) of a shape [m^D].
double measure(const Shape& shape, int dimension);

/// Numbers of particles, frames and readings that a run has; zero for phases that it does not have.
struct Amounts {
  double fluid = 0.0, solid = 0.0;  ///< particles at the start
  double fluid_full = 0.0;          ///< water particles once all soil is full, where faces let water in
  double frames = 0.0;
  double frame_bytes = 0.0;   ///< of all frames together
  double gauge_rows = 0.0;    ///< 0 where every exchange is read: their number is not known
  double memory_bytes = 0.0;  ///< of all processes together
  double factor_bytes = 0.0;  ///< of that, for the factors of the soil's stiffness (3D with water)
};
Amounts estimate(const Case& scene);

/// The finest particle spacing of the phases that run [m].
double finest_spacing(const Case& scene);

/// A spacing at which the box around the shape holds so few particles that looking at them all takes no time: the
/// given one, or a coarser one.
double spacing_to_look_at(const Shape& shape, double spacing, int dimension);

}  // namespace poretwin
