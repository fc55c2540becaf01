// The fluid phase: incompressible SPH in and around a porous medium.
#pragma once

#include "common/case/case.hpp"
#include "common/coupling/phase.hpp"

#include <memory>

namespace poretwin::fluid {

/// The fluid of a case, 2D or 3D, at time zero. Throws CaseError when the case has neither a region of water nor a
/// water face.
std::unique_ptr<Phase> make_fluid(const Case& scene);

}  // namespace poretwin::fluid
