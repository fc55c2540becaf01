// Chosen numbers of the return to the cone. What an entry needs: CONTRIBUTING.md.
#pragma once

namespace poretwin::solid::material {

/// Relative difference from which on a logarithmic mean is taken as such; below, an arithmetic one is as exact.
/// Unit: 1. Test: none known.
inline constexpr double logarithmic_from = 1e-4;
/// Angle by which a trial turns the deviator, up to which it is taken not to turn it.
/// Unit: rad. Test: none known.
inline constexpr double little_angle = 0.005;

}  // namespace poretwin::solid::material
