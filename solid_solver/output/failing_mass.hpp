// The part of the soil that fails at the factor of safety, and the direction in which it moves.
#pragma once

#include "solid_solver/statics/safety.hpp"

#include <optional>

namespace poretwin::solid {

/// Soil may fail on two sides at once, as on both slopes of a dam. The members are means over the side with more
/// motion, weighted with mass times displacement in the failing trial, so that soil that does not move has no weight.
template <int D>
struct FailingMass {
  double share = 1.0;               ///< fraction of the motion of all soil, sum m u, on this side
  std::size_t soil = 0;             ///< the soil with the largest part of that motion
  Vec<D> centre = Vec<D>::Zero();   ///< m
  Vec<D> towards = Vec<D>::Zero();  ///< unit, mean direction of the displacement
  double volume = 0.0;              ///< m^D: (sum V u)^2 / (sum V u^2), the volume if the side moved by one u
};

/// The result is empty where nothing fails: the soil is stable at every factor that was tried. displacement: of the
/// free particles in the failing trial [m].
template <int D>
std::optional<FailingMass<D>> failing_mass(const Setup<D>& setup, const State<D>& state,
                                           const VecArray<D>& displacement);

}  // namespace poretwin::solid
