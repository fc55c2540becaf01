// Loops by lanes with every set of instructions that this machine has.
#pragma once

#include "common/core/lanes.hpp"

namespace poretwin::test {

/// Calls f once with each set up to the best one; that one is set again afterwards.
template <class F>
void with_each_instruction_set(F&& f) {
  const Instructions best = instructions();
  for (const Instructions lower :
       {Instructions::scalar, Instructions::plain, Instructions::avx2, Instructions::avx512}) {
    if (lower > best) continue;
    instructions() = lower;
    f();
  }
  instructions() = best;
}

}  // namespace poretwin::test
