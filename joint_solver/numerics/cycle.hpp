// Chosen numbers of the exchange between free water and ground. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::joint::cycle {

/// Longest step of the ground. The shortest waves of free water that particles resolve, some four spacings long, take
/// some 16 windows for a period.
/// Unit: windows of the free water. Test: none known.
inline constexpr double windows = 4.0;
/// Largest depth of water that passes a part of the surface in a step of the ground, at the rate of the last step. It
/// bounds the water that stands between the two, in the film on the surface.
/// Unit: spacings. Test: none known.
inline constexpr double depth = 0.125;

}  // namespace poretwin::joint::cycle
