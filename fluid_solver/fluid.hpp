// The fluid phase: incompressible SPH in and around a porous medium.
#pragma once

#include "common/case/case.hpp"
#include "common/coupling/phase.hpp"
#include "common/particles/tiling.hpp"

#include <memory>

namespace poretwin::fluid {

/// The fluid of a case, 2D or 3D, at time zero. Throws CaseError when the case has neither a region of water nor a
/// water face.
std::unique_ptr<Phase> make_fluid(const Case& scene);

/// The part of one rank in the water of a case that several ranks share (fluid_solver/shared_fluid.hpp).
template <int D>
std::unique_ptr<Phase> make_shared_fluid(const Case& scene, std::shared_ptr<Tiling<D>> tiling);

}  // namespace poretwin::fluid
