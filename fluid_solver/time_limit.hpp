// A bound on the next window.
#pragma once

#include <cmath>
#include <string>

namespace poretwin::fluid {

/// A bound on the next window and the reason for it.
struct TimeLimit {
  double interval = HUGE_VAL;  ///< s
  std::string reason;
};

}  // namespace poretwin::fluid
