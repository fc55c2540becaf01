// What a case may say and hardly means: units mixed up, layers of a few particles, keys without effect.
#pragma once

#include "common/case/case.hpp"
#include "common/case/keys.hpp"

#include <string>
#include <vector>

namespace poretwin {

/// One line each: file, line, key, what looks wrong, what to do.
std::vector<std::string> doubts(const Case& scene, const Places& places);

}  // namespace poretwin
