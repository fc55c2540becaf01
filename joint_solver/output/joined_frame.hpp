// One frame of two sets of points.
#pragma once

#include "common/coupling/phase.hpp"

namespace poretwin::joint {

/// The points of the free water, then those in the soil. Fields that only one of them has are NaN at the other;
/// `in_soil` tells the two apart.
OutputFrame joined(OutputFrame free, OutputFrame ground);

}  // namespace poretwin::joint
