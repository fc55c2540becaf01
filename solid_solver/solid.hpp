// The solid phase: elasto-plastic soil skeleton in SPH.
#pragma once

#include "common/case/case.hpp"
#include "common/coupling/phase.hpp"

#include <memory>

namespace poretwin::solid {

/// The soil skeleton of a case, 2D or 3D, at time zero. Throws CaseError when no soil lies in the case's shapes.
std::unique_ptr<Phase> make_solid(const Case& scene);

}  // namespace poretwin::solid
