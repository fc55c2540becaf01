// Chosen numbers of soil that flows: the upkeep of its stress and packing. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::solid::flow {

/// Way of waves between two treatments, at least.
/// Unit: spacings. Test: none known.
inline constexpr double travel = 3.0;
/// Time between two, at least: every fourth of the longest substeps is one.
/// Unit: longest substeps. Test: none known.
inline constexpr double substeps = 3.5;
/// Share of the neighbours' average in a stress that is evened out.
/// Unit: 1. Test: none known.
inline constexpr double stress_share = 0.5;
/// The same in a volume.
/// Unit: 1. Test: none known.
inline constexpr double volume_share = 0.2;
/// Share of the error of sum V W by which a volume is corrected.
/// Unit: 1. Test: none known.
inline constexpr double packing_share = 0.1;
/// Motion per crowding and shear strain.
/// Unit: h^2. Test: none known.
inline constexpr double evening = 1.0;
/// Longest such motion.
/// Unit: spacings. Test: none known.
inline constexpr double longest_move = 0.05;
/// Shear strain in which a stress is evened out.
/// Unit: the elastic one, tau / G. Test: none known.
inline constexpr double renewing = 0.1;
/// Most that is evened out of the stress of soil that yielded a little: what evening out stirs must die out, or soil
/// would never rest (thirty was too much).
/// Unit: G times the plastic strain since. Test: RegularFlow.EvensOutStressWhereSoilYieldedALittleAndNothingElse (untried).
inline constexpr double evened_out = 3.0;
/// |sum V grad W| h beyond which a particle lies at a surface; a flat one has 0.7.
/// Unit: 1. Test: none known.
inline constexpr double surface = 0.25;
/// Coverage, over that of soil as it was laid, below which it does, too.
/// Unit: 1. Test: none known.
inline constexpr double inside_cover = 0.8;
/// Volumetric strain per shear strain and relative density.
/// Unit: 1. Test: none known.
inline constexpr double dilatancy = 2.0;
/// Largest shear strain between two treatments that counts: loose particles see more.
/// Unit: 1. Test: none known.
inline constexpr double largest_strain = 0.1;
/// Largest excess of relative density that counts.
/// Unit: 1. Test: none known.
inline constexpr double largest_excess = 0.1;

/// Share of their pores that colliding grains keep.
/// Unit: 1. Test: none known.
inline constexpr double pores_left = 0.1;
/// Bulk volume over its initial one beyond which grains of soil without cohesion and dilation are apart: no stress,
/// only collisions. Porosity 0.40 -> 0.45, the loosest random packing of spheres.
/// Unit: 1. Test: none known.
inline constexpr double loosest = 1.1;

}  // namespace poretwin::solid::flow
