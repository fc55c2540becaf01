// Chosen numbers of the corrections that keep flowing soil regular. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::solid::flow {

/// Distance that elastic waves travel between two corrections of flowing soil, at least.
/// Unit: spacings. Test: none known.
inline constexpr double travel = 3.0;
/// Time between two corrections of flowing soil, at least: at the longest substep one follows every fourth substep.
/// Unit: longest substeps. Test: none known.
inline constexpr double substeps = 3.5;
/// Fraction of what the neighbours' linear fields do not explain of a particle's stress that a correction removes.
/// Unit: 1. Test: none known.
inline constexpr double stress_share = 0.5;
/// Fraction of the neighbours' average that a corrected volume takes in.
/// Unit: 1. Test: none known.
inline constexpr double volume_share = 0.2;
/// Fraction of the error of sum V W by which a correction changes a particle's volume.
/// Unit: 1. Test: none known.
inline constexpr double packing_share = 0.1;
/// Displacement that evens out the packing, per shear strain and
/// sum V grad W
/// .
/// Unit: h^2. Test: none known.
inline constexpr double evening = 1.0;
/// Longest displacement of a correction that evens out the packing.
/// Unit: spacings. Test: none known.
inline constexpr double longest_move = 0.05;
/// Shear strain since the last correction from which on this one acts in full: by then the stress has been renewed.
/// Unit: the elastic one, tau / G. Test: none known.
inline constexpr double renewing = 0.1;
/// Largest correction of the stress of a pair in soil that yielded a little. The motion that a correction causes must
/// die out, or soil would never come to rest (it does not with thirty).
/// Unit: G times the plastic strain since. Test: RegularFlow.EvensOutStressWhereSoilYieldedALittleAndNothingElse (untried).
inline constexpr double evened_out = 3.0;
/// Asymmetry
/// sum V grad W
/// h beyond which a particle lies at a surface; a flat surface has 0.7.
/// Unit: 1. Test: none known.
inline constexpr double surface = 0.25;
/// Sum V W, over that of soil on its initial lattice, below which a particle lies at a surface.
/// Unit: 1. Test: none known.
inline constexpr double inside_cover = 0.8;
/// Volumetric strain of the correction of density, per shear strain and excess of relative density.
/// Unit: 1. Test: none known.
inline constexpr double dilatancy = 2.0;
/// Largest shear strain between two corrections that counts: loose particles have larger ones.
/// Unit: 1. Test: none known.
inline constexpr double largest_strain = 0.1;
/// Largest excess of relative density, rho / rho_0 - 1 - p / K with the mean stress -p and bulk modulus K, that counts.
/// Unit: 1. Test: none known.
inline constexpr double largest_excess = 0.1;

/// Fraction of their first volume of pores that colliding grains keep.
/// Unit: 1. Test: none known.
inline constexpr double pores_left = 0.1;
/// Bulk volume over its initial one beyond which grains of soil without cohesion and dilation are apart: no stress,
/// only collisions. Porosity 0.40 -> 0.45, the loosest random packing of spheres.
/// Unit: 1. Test: none known.
inline constexpr double loosest = 1.1;

}  // namespace poretwin::solid::flow
