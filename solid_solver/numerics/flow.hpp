// Chosen numbers of the corrections that smooth stress, volumes and packing in flowing soil. What an entry needs:
// CONTRIBUTING.md. Symbols: V bulk volume, W kernel, h smoothing length, G shear modulus, tau shear stress.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::solid::flow {

/// Least distance that elastic waves travel between two corrections of flowing soil.
/// Unit: spacings. Test: none known.
inline constexpr double travel = 3.0;
/// Least time between two corrections of flowing soil. At the longest substep a correction follows every fourth
/// substep.
/// Unit: longest substeps. Test: none known.
inline constexpr double substeps = 3.5;
/// Fraction of the departure of a particle's stress from its neighbours' linear stress fields that a correction
/// removes.
/// Unit: 1. Test: none known.
inline constexpr double stress_share = 0.5;
/// Fraction by which a correction moves a particle's volume towards the average of its neighbours.
/// Unit: 1. Test: none known.
inline constexpr double volume_share = 0.2;
/// Equivalent plastic strain since the last correction from which on the volumes of wet soil are evened out in full,
/// below it in proportion. The volumes of rows that slide past each other err by some 6e-4 of the shear.
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
/// Shear strain since the last correction from which on a correction acts in full: by then shearing has renewed the
/// stress.
/// Unit: the elastic one, tau / G. Test: none known.
inline constexpr double renewing = 0.1;
/// Largest correction of the stress between a pair of particles in soil that has yielded a little. The motion that a
/// correction causes must die out, otherwise the soil never comes to rest (with 30 it does not).
/// Unit: G times the plastic strain since. Test: RegularFlow.EvensOutStressWhereSoilYieldedALittleAndNothingElse (untried).
inline constexpr double evened_out = 3.0;
/// Asymmetry |sum V grad W| h beyond which a particle counts as lying at a surface. At a flat surface it is 0.7.
/// Unit: 1. Test: none known.
inline constexpr double surface = 0.25;
/// Sum V W, over that of soil on its initial lattice, below which a particle lies at a surface.
/// Unit: 1. Test: none known.
inline constexpr double inside_cover = 0.8;
/// Volumetric strain that corrects the density, per shear strain and per density error
/// (`largest_excess`).
/// Unit: 1. Test: none known.
inline constexpr double dilatancy = 2.0;
/// Largest shear strain between two corrections that is taken into account: loose particles have larger ones.
/// Unit: 1. Test: none known.
inline constexpr double largest_strain = 0.1;
/// Largest magnitude of the density error that the correction uses (see `dilatancy`): rho / rho_0 - 1 - p / K with the
/// bulk density rho, its initial value rho_0, the mean effective pressure p and the bulk modulus K.
/// Unit: 1. Test: none known.
inline constexpr double largest_excess = 0.1;

/// Fraction of their initial volume of pores that colliding grains keep at least.
/// Unit: 1. Test: none known.
inline constexpr double pores_left = 0.1;
/// Bulk volume over its initial value beyond which the grains of soil without cohesion and dilation count as apart:
/// they carry no stress and only collide. At a porosity of 0.40 initially this is 0.45, the loosest random packing of
/// spheres.
/// Unit: 1. Test: none known.
inline constexpr double loosest = 1.1;

}  // namespace poretwin::solid::flow
