// Chosen numbers of the exchange of fields with the water, on the soil's side. What an entry needs: CONTRIBUTING.md.
#pragma once

namespace poretwin::solid::exchange {

/// Ratio of a particle's coverage by water to its coverage by soil from which on it counts as saturated. It is below 1
/// because the coverage (sum V W) of disordered points scatters by some percent.
/// Unit: 1. Test: Saturation.WaterCountsAgainstTheSoilsOwnShareOfTheSurroundings.
inline constexpr double full_saturation = 0.95;
/// Fraction of soil that the fluid reports at a point (soil_fraction), below which the soil there does not track the
/// motion that the fluid predicts.
/// Unit: 1. Test: none known.
inline constexpr double least_seen = 1e-6;

/// Constrained modulus that the soil reports in motion, over the elastic one. The water's prediction resists every
/// deformation with it, also shear at constant volume, which elastic soil resists with its shear modulus (0.29 of the
/// constrained one at a Poisson's ratio of 0.3) and yielding soil hardly. A prediction that is more than twice too stiff
/// overshoots in every window: with 0.6 the pressure in yielding soil beside a column of water goes back and forth by
/// 30 kPa, with 0.5 shear waves in elastic soil grow. One that is too soft needs some more windows to follow the soil.
/// Unit: 1. Test: Submerged.PressureUnderSoilThatFlowsDoesNotAlternate (untried).
inline constexpr double modulus_in_motion = 0.3;

/// Length of the surface vector (surface_vectors()) times the spacing from which on a particle counts as lying at a
/// free surface. It is 1 in the first row and some hundredths at disordered points inside the soil.
/// Unit: over the spacing. Test: none known.
inline constexpr double surface = 0.02;
/// Length of the surface vector times the spacing from which on a particle counts as in the first row at a free
/// surface. On a lattice it is 1.47 in the first row, 0.44 to 0.46 in the second.
/// Unit: over the spacing. Test: FieldWithSoil.BearsASuddenLoadWhollyInSpace.
inline constexpr double first_row = 0.8;

}  // namespace poretwin::solid::exchange
