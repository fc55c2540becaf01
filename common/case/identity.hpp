// Identifies the run to which a checkpoint belongs: by the case with all its settings, and by the program.
#pragma once

#include "common/case/case.hpp"
#include "common/checkpoint/store.hpp"
#include "common/core/hash.hpp"
#include "common/output/build_info.hpp"

#include <fmt/format.h>

namespace poretwin {

/// The identity of the case, which is the same for all programs of a run.
inline RunIdentity case_identity(const Case& scene) {
  std::string overrides;
  for (const auto& assignment : scene.overrides) overrides += (overrides.empty() ? "" : " ") + assignment;
  return {{"case file", fmt::format("{:016x}", fnv1a(scene.text))},
          {"--set", overrides.empty() ? "nothing" : overrides}};
}

/// The identity of the case, with the hash of the running program.
inline RunIdentity run_identity(const Case& scene) {
  RunIdentity identity = case_identity(scene);
  identity.emplace_back(program_entry,
                        fmt::format("{}, {}, hash {}", version(), build(), program_hash("/proc/self/exe")));
  return identity;
}

}  // namespace poretwin
