// `poretwin check`: what a case will be, without running it.
#pragma once

#include "common/case/case.hpp"

#include <cstddef>
#include <string>

namespace poretwin::cli {

struct ParticleCount {
  std::size_t fluid = 0, solid = 0;
};
ParticleCount count_particles(const Case& scene);

/// Throws CaseError when the case needs more memory than this machine has, by estimate.
void expect_memory(const Case& scene);

/// Particles, spacing, the intervals that are stable and what sets them, memory.
std::string check_text(const Case& scene);

}  // namespace poretwin::cli
