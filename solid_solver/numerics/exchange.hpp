// Chosen numbers of the exchange of fields with the water, on the soil's side. What an entry needs: CONTRIBUTING.md.
#pragma once

namespace poretwin::solid::exchange {

/// A particle counts as saturated where its coverage by water, over its coverage by soil, is at least this value. The
/// value is below 1 because the coverage (sum V W) of disordered points scatters by some percent.
/// Unit: 1. Test: Saturation.WaterCountsAgainstTheSoilsOwnShareOfTheSurroundings.
inline constexpr double full_saturation = 0.95;
/// The soil at a point tracks the motion that the fluid predicts only where the fraction of soil that the fluid reports
/// there (soil_fraction) exceeds this value.
/// Unit: 1. Test: none known.
inline constexpr double least_seen = 1e-6;

/// Constrained modulus that the soil reports in motion, over the elastic modulus. The water's prediction resists every
/// deformation with this modulus, also shear at constant volume. Elastic soil resists such shear with its shear modulus
/// (0.29 of the constrained one at a Poisson's ratio of 0.3), and yielding soil hardly resists it. A prediction more
/// than twice too stiff overshoots in every window: with 0.6 the pressure in yielding soil beside a column of water
/// alternates by 30 kPa, with 0.5 shear waves in elastic soil grow. A too soft one follows the soil some windows later.
/// Unit: 1. Test: Submerged.PressureUnderSoilThatFlowsDoesNotAlternate (untried).
inline constexpr double modulus_in_motion = 0.3;

/// The same where the grains are in suspension. They have no stiffness, but a prediction without any lets motion grow
/// that alternates from row to row; with 1 the passes through a window hardly converge.
/// Unit: 1. Test: liquefied_column (untried).
inline constexpr double modulus_in_suspension = 0.1;

/// A particle counts as lying at a free surface where the length of its surface vector (surface_vectors()) times the
/// spacing is at least this: it is of order 1 in the first row, some hundredths at disordered points inside the soil.
/// Unit: 1. Test: none known.
inline constexpr double surface = 0.02;
/// A particle counts as in the first row at a free surface where the length of its surface vector times the spacing is
/// at least this. On a lattice this product is 1.47 in the first row, 0.44 to 0.46 in the second.
/// Unit: 1. Test: FieldWithSoil.BearsASuddenLoadWhollyInSpace.
inline constexpr double first_row = 0.8;

}  // namespace poretwin::solid::exchange
