// Which run a checkpoint belongs to: the case, with everything that was set, and the program.
#pragma once

#include "common/case/case.hpp"
#include "common/checkpoint/store.hpp"
#include "common/core/hash.hpp"
#include "common/output/build_info.hpp"

#include <fmt/format.h>

namespace poretwin {

inline RunIdentity run_identity(const Case& scene) {
  std::string overrides;
  for (const auto& assignment : scene.overrides) overrides += (overrides.empty() ? "" : " ") + assignment;
  return {{"program", version() + ", " + build()},
          {"case file", fmt::format("{:016x}", fnv1a(scene.text))},
          {"--set", overrides.empty() ? "nothing" : overrides}};
}

}  // namespace poretwin
