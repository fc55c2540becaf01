// Pore water that the case prescribes, for soil that runs alone.
#pragma once

#include "solid_solver/setup.hpp"

#include <optional>

namespace poretwin::solid {

/// Pressure [Pa] of the case's [[pore_pressure]] at x [m] and time t [s]; nothing where the soil is dry.
std::optional<double> prescribed_pressure(const WaterSetup& setup, const Point3& x, double t);

/// The next time after t [s] at which a prescribed pressure changes its rate; infinite when none does.
double next_change_after(const WaterSetup& setup, double t);

}  // namespace poretwin::solid
