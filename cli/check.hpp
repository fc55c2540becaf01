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

/// Throws CaseError when the case needs more memory than this machine has, by estimate.
void expect_memory(const Case& scene);

/// The longest stable window that one cause allows.
struct Limit {
  double seconds;
  std::string what;
};

struct CheckReport {
  Amounts amounts;
  ParticleCount particles;
  bool estimated = false;        ///< whether the particles are estimated, being too many to be made and counted
  std::vector<Limit> intervals;  ///< shortest first
};
CheckReport report_of(const Case& scene);

/// Text with the particles, their spacing, the stable intervals and what limits them, and the memory.
std::string check_text(const Case& scene, const CheckReport& report);
nlohmann::ordered_json check_json(const Case& scene, const CheckReport& report);

}  // namespace poretwin::cli
