// Energy of the water particles.
#pragma once

#include "fluid_solver/fluid_phase.hpp"

namespace poretwin::fluid::test {

/// Kinetic and potential energy [J/m].
inline double energy(const Fluid<2>& fluid) {
  const auto& p = fluid.state().particles;
  double sum = 0.0;
  for (std::size_t a = 0; a < p.size(); ++a)
    sum += p.mass[a] * (0.5 * p.velocity[a].squaredNorm() + 9.81 * p.position[a].y());
  return sum;
}

}  // namespace poretwin::fluid::test
