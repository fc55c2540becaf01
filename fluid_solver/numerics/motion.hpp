// Chosen numbers of how particles of water move, keep their packing and are damped. What an entry needs:
// CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::fluid::motion {

/// Numerical viscosity of free water on the shear itself: without any it is slowly unstable.
/// Unit: spacings times the speed of long waves. Test: FreeWater.DisorderedTankStaysQuiet (untried).
inline constexpr double shear_viscosity = 0.01;
/// The same on the shear's non-linear part.
/// Unit: spacings times the speed of long waves. Test: FreeWater.VorticesDecayAtTheRateOfTheViscosity (untried).
inline constexpr double noise_viscosity = 0.05;
/// The same on pairs that approach.
/// Unit: h times the speed of approach. Test: none known.
inline constexpr double impact_viscosity = 0.5;
/// The same of explicit sweeps on the shear: they transmit sound and need as much as weakly compressible SPH, alpha h
/// c/(2 (D + 2)) with alpha of at least 0.03 and c = 10 sqrt(g H) (Monaghan 1994).
/// Unit: spacings times the speed of long waves. Test: Eisph.DisorderedTankStaysQuiet (untried).
inline constexpr double sweep_viscosity = 0.05;
/// Distance at which particles belong to one body of water, whose depth gives the speed of its longest waves.
/// Unit: spacings. Test: Locality.ADeepPoolFarAwayLeavesFreeWaterAsItIs (untried).
inline constexpr double touching = 1.6;
/// |sum V grad W| h up to which surroundings are even, and the divergence of short windows is not deferred; at a flat
/// surface 0.7.
/// Unit: 1. Test: FreeWater.ShortWindowsFeedItNoEnergy (untried).
inline constexpr double even_surroundings = 0.05;

/// Shifting in soil: per |v| dt h.
/// Unit: 1. Test: Seepage.WaterPressedIntoDrySoilKeepsItsPacking (untried).
inline constexpr double shift_by_speed_in_soil = 0.5;
/// The same in free water.
/// Unit: 1. Test: none known.
inline constexpr double shift_by_speed_in_free_water = 2.0;
/// The same in soil that is full, where no surface is in the way, as fast as in free water: the conductance of uneven
/// points is below that of even ones (layered_soil 1.0 % low at 0.5, 0.7 % at 2).
/// Unit: 1. Test: layered_soil (untried).
inline constexpr double shift_by_speed_in_full_soil = 2.0;
/// Shifting per h^2, everywhere, of points that do not move, too.
/// Unit: 1. Test: none known.
inline constexpr double shift_by_length = 0.01;
/// Separation below which pairs are pushed apart in soil.
/// Unit: spacings. Test: none known.
inline constexpr double closest_in_soil = 0.8;
/// The same in free water.
/// Unit: spacings. Test: none known.
inline constexpr double closest_in_free_water = 0.6;
/// Share of what a pair is too close by that each of its two is pushed per window: half of it, by both.
/// Unit: 1. Test: none known.
inline constexpr double push = 0.25;
/// Longest shift in a window.
/// Unit: spacings. Test: none known.
inline constexpr double longest_shift = 0.1;
/// Separation at which approaching particles of free water collide.
/// Unit: spacings. Test: none known.
inline constexpr double collision = 0.5;

/// Residual of the repair of full soil: what is left is taken up by the next windows, whose repair is of the points as
/// they are then.
/// Unit: 1. Test: none known.
inline constexpr double repair_tolerance = 1e-2;
/// Iterations of that.
/// Unit: iterations. Test: none known.
inline constexpr int most_repair_iterations = 200;

/// Displacement after which a particle's packing counts in full, in soil.
/// Unit: spacings. Test: none known.
inline constexpr double repair_displacement = 0.25;
/// The same in free water, where only a lattice at rest has nothing to repair.
/// Unit: spacings. Test: none known.
inline constexpr double free_repair_displacement = 0.01;
/// Time in which a packing error is undone in free water: twenty times a fall through one spacing.
/// Unit: sqrt(spacing / g). Test: none known.
inline constexpr double free_repair_falls = 20.0;
/// The same where drag holds the water.
/// Unit: the drag's own time. Test: none known.
inline constexpr double held_repair_times = 20.0;
/// The same in soil: a third of what a unit gradient needs to push water through one spacing.
/// Unit: 1. Test: Seepage.WaterPressedIntoDrySoilKeepsItsPacking (untried).
inline constexpr double pushed_repair = 0.3;
/// The least of all these: a repair that overtakes its window swings.
/// Unit: windows. Test: none known.
inline constexpr double repair_windows = 2.0;
/// Way in a window from which on shifting is in full.
/// Unit: spacings. Test: none known.
inline constexpr double shifts_from = 0.02;

/// Strain in a window up to which the surface is led by it and its square conserves volume. No reason on record.
/// Unit: 1. Test: none known.
inline constexpr double most_strain = 0.2;
/// How fast a deficit of packing stops to be an error where the kernel is cut off, per |sum V grad W| h.
/// Unit: 1. Test: none known.
inline constexpr double cut_off = 5.0;

}  // namespace poretwin::fluid::motion
