// Which part of the soil fails at the factor of safety, and whereto.
#pragma once

#include "solid_solver/statics/safety.hpp"

#include <optional>

namespace poretwin::solid {

/// Means over the soil, weighted with mass times displacement in the failing trial, so that soil that stays does not
/// count.
template <int D>
struct FailingMass {
  std::size_t soil = 0;              ///< the soil with the largest part of it
  Vec<D> centre = Vec<D>::Zero();    ///< m
  Vec<D> towards = Vec<D>::Zero();   ///< unit, mean direction of the displacement
  double volume = 0.0;               ///< m^D: (sum V u)^2 / (sum V u^2), its volume if all of it moved by the same u
};

/// Empty where nothing fails: the soil stands at any factor that was tried.
template <int D>
std::optional<FailingMass<D>> failing_mass(const State<D>& state, const VecArray<D>& displacement);

}  // namespace poretwin::solid
