// Pore water that the case prescribes, for soil that runs without a fluid.
#pragma once

#include "solid_solver/setup.hpp"

#include <optional>

namespace poretwin::solid {

/// Pressure [Pa] of the case's [[pore_pressure]] at x [m] and time t [s]; empty where the soil is dry.
std::optional<double> prescribed_pressure(const WaterSetup& setup, const Point3& x, double t);

/// The next time [s] after t [s] at which a prescribed pressure changes its rate; infinite if none follows.
double next_change_after(const WaterSetup& setup, double t);

}  // namespace poretwin::solid
