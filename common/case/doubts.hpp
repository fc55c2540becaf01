// Warnings about contents that are allowed in a case but hardly intended: mistaken units, layers of a few particles,
// keys without effect.
#pragma once

#include "common/case/case.hpp"
#include "common/case/keys.hpp"

#include <string>
#include <vector>

namespace poretwin {

/// One line per warning: file, line, key, the likely fault, and what to do.
std::vector<std::string> doubts(const Case& scene, const Places& places);

}  // namespace poretwin
