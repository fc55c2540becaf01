// Chosen numbers of the corrections that smooth stress, volumes and packing in flowing soil. What an entry needs:
// CONTRIBUTING.md. Symbols: V bulk volume, W kernel, h smoothing length, G shear modulus, tau shear stress.
// (untried) behind a test's name: the test has not yet been seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::solid::flow {

/// Least distance that elastic waves travel between two corrections of flowing soil.
/// Unit: spacings. Test: none known.
inline constexpr double travel = 3.0;
/// Least time between two corrections of flowing soil. At the longest substep a correction follows every fourth
/// substep.
/// Unit: longest substeps. Test: none known.
inline constexpr double substeps = 3.5;
/// A correction removes this fraction of the difference between a particle's stress and the linear stress fields of its
/// neighbours.
/// Unit: 1. Test: none known.
inline constexpr double stress_share = 0.5;
/// Fraction by which a correction moves a particle's volume towards the average of its neighbours.
/// Unit: 1. Test: none known.
inline constexpr double volume_share = 0.2;
/// The volumes of wet soil are evened out in full where the equivalent plastic strain since the last correction is at
/// least this, below it in proportion. The volumes of rows that slide past each other err by some 6e-4 of the shear.
/// Unit: 1. Test: RegularFlow.EvensOutVolumesOfWetSoilByWhatItYields.
inline constexpr double volume_renewing = 0.001;
/// Fraction of the error of sum V W by which a correction changes a particle's volume.
/// Unit: 1. Test: none known.
inline constexpr double packing_share = 0.1;
/// Displacement that evens out the packing, per shear strain and per |sum V grad W|.
/// Unit: h^2. Test: none known.
inline constexpr double evening = 1.0;
/// Longest displacement by which a correction evens out the packing.
/// Unit: spacings. Test: none known.
inline constexpr double longest_move = 0.05;
/// A correction acts in full where the shear strain since the last correction is at least this value: by then shearing
/// has renewed the stress.
/// Unit: elastic shear strain tau / G. Test: none known.
inline constexpr double renewing = 0.1;
/// Largest correction of the stress between a pair of particles in soil that has yielded a little since the last
/// correction. The motion that a correction causes must die out: with 30 the soil never comes to rest.
/// Unit: G times plastic strain. Test: RegularFlow.EvensOutStressWhereSoilYieldedALittleAndNothingElse.
inline constexpr double evened_out = 3.0;
/// A particle counts as lying at a surface where |sum V grad W| h exceeds this. At a flat surface it is 0.7.
/// Unit: 1. Test: none known.
inline constexpr double surface = 0.25;
/// A particle lies at a surface where the sum of V W, over that of soil on its initial lattice, is below this value.
/// Unit: 1. Test: none known.
inline constexpr double inside_cover = 0.8;
/// A volumetric strain corrects the density. This is its amount per shear strain and per density error
/// (`largest_excess`).
/// Unit: 1. Test: none known.
inline constexpr double dilatancy = 2.0;
/// Upper bound of the shear strain between two corrections that a correction uses: loose particles have larger strains.
/// Unit: 1. Test: none known.
inline constexpr double largest_strain = 0.1;
/// Largest magnitude of the density error that the correction uses (see `dilatancy`): rho / rho_0 - 1 - p / K with the
/// bulk density rho, its initial value rho_0, the mean effective pressure p and the bulk modulus K.
/// Unit: 1. Test: none known.
inline constexpr double largest_excess = 0.1;

/// Grains that collide keep at least this fraction of the initial volume of their pores.
/// Unit: 1. Test: none known.
inline constexpr double pores_left = 0.1;
/// Where the bulk volume over its initial value exceeds this, the grains of soil without cohesion and dilation count as
/// apart: they carry no stress and only collide. For an initial porosity of 0.40 this corresponds to 0.45, the porosity
/// of the loosest random packing of spheres.
/// Unit: 1. Test: none known.
inline constexpr double loosest = 1.1;

}  // namespace poretwin::solid::flow
