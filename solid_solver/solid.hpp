// The solid phase: elasto-plastic soil skeleton in SPH.
#pragma once

#include "common/case/case.hpp"
#include "common/coupling/phase.hpp"
#include "common/particles/tiling.hpp"

#include <memory>

namespace poretwin::solid {

/// The soil skeleton of a case, 2D or 3D, at time zero. Throws CaseError when no soil lies in the case's shapes.
std::unique_ptr<Phase> make_solid(const Case& scene);

/// This rank's part of soil that several ranks share (shared_solid.hpp). Throws CaseError, before any rank has sent
/// anything, where the case has what several ranks cannot compute.
template <int D>
std::unique_ptr<Phase> make_shared_solid(const Case& scene, std::shared_ptr<Tiling<D>> tiling);

}  // namespace poretwin::solid
