// `poretwin check`: particles, stable window lengths and memory of a case, without running it.
#pragma once

#include "common/case/amounts.hpp"
#include "common/case/case.hpp"

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace poretwin::cli {

struct ParticleCount {
  std::size_t fluid = 0, solid = 0;
};
ParticleCount count_particles(const Case& scene);

/// Throws CaseError when the estimated memory of the case exceeds the memory of this machine.
void expect_memory(const Case& scene);

/// The longest stable window by one criterion.
struct Limit {
  double seconds;
  std::string what;
};

struct CheckReport {
  Amounts amounts;
  ParticleCount particles;
  bool estimated = false;        ///< whether the numbers of particles are estimated, not counted
  std::vector<Limit> intervals;  ///< shortest first
};
CheckReport report_of(const Case& scene);

/// Text with the particles, their spacing, the longest stable windows with their criteria, and the memory.
std::string check_text(const Case& scene, const CheckReport& report);
nlohmann::ordered_json check_json(const Case& scene, const CheckReport& report);

}  // namespace poretwin::cli
