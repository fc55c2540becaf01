// Chosen numbers of soil that free water carries off. What an entry needs: CONTRIBUTING.md.
#pragma once

namespace poretwin::solid::erosion {

/// Coverage by soil, sum V W with the particle itself, below which a particle belongs to no body: it has no surface to
/// erode and no strength, and the stream takes it at once. In 2D one grain has 0.39, a pair that touches 0.51, a right
/// corner of a body 0.67.
/// Unit: 1. Test: Erosion.AGrainByItselfIsCarriedOffAtOnce.
inline constexpr double least_coverage = 0.4;

}  // namespace poretwin::solid::erosion
