// Which part of the soil fails at the factor of safety, and whereto.
#pragma once

#include "solid_solver/statics/safety.hpp"

#include <optional>

namespace poretwin::solid {

/// Soil may fail on two sides at once, as both slopes of a dam. These are means over the side on which more moves,
/// weighted with mass times displacement in the failing trial, so that soil that stays does not count.
template <int D>
struct FailingMass {
  double share = 1.0;               ///< of the motion of all soil, sum m u, on this side
  std::size_t soil = 0;             ///< the soil with the largest part of it
  Vec<D> centre = Vec<D>::Zero();   ///< m
  Vec<D> towards = Vec<D>::Zero();  ///< unit, mean direction of the displacement
  double volume = 0.0;              ///< m^D: (sum V u)^2 / (sum V u^2), the volume if all of it moved by the same u
};

/// Empty where nothing fails: the soil stands at any factor that was tried. displacement: of the free particles in the
/// failing trial [m].
template <int D>
std::optional<FailingMass<D>> failing_mass(const Setup<D>& setup, const State<D>& state,
                                           const VecArray<D>& displacement);

}  // namespace poretwin::solid
