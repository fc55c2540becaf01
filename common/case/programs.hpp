// Names of the programs that compute the phases of a case.
#pragma once

#include "common/case/case.hpp"

namespace poretwin {

/// The program that computes water in this representation, without the prefix "poretwin-".
inline const char* water_program(FluidCase::Representation representation) {
  switch (representation) {
    case FluidCase::Representation::field:
      return "pore";
    case FluidCase::Representation::both:
      return "joint";
    default:
      return "fluid";
  }
}

}  // namespace poretwin
