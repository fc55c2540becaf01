// Chosen numbers of how particles of water move, keep their packing and are damped. What an entry needs:
// CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::fluid::motion {

/// Numerical viscosity of free water on the shear itself: without any it is slowly unstable.
/// Unit: spacings times the speed of long waves. Test: FreeWater.DisorderedTankStaysQuiet (untried).
inline constexpr double shear_viscosity = 0.01;
/// Numerical viscosity of free water on the non-linear part of the shear.
/// Unit: spacings times the speed of long waves. Test: FreeWater.VorticesDecayAtTheRateOfTheViscosity (untried).
inline constexpr double noise_viscosity = 0.05;
/// Numerical viscosity of free water on pairs that approach each other.
/// Unit: h times the speed of approach. Test: none known.
inline constexpr double impact_viscosity = 0.5;
/// Numerical viscosity on the shear in place of shear_viscosity where explicit sweeps find the pressure: these transmit
/// sound and need as much as weakly compressible SPH, alpha h c/(2 (D + 2)) with alpha of at least 0.03 and c = 10
/// sqrt(g H) (Monaghan 1994).
/// Unit: spacings times the speed of long waves. Test: Eisph.DisorderedTankStaysQuiet (untried).
inline constexpr double sweep_viscosity = 0.05;
/// Distance at which particles belong to one body of water, whose depth gives the speed of its longest waves.
/// Unit: spacings. Test: Locality.ADeepPoolFarAwayLeavesFreeWaterAsItIs (untried).
inline constexpr double touching = 1.6;
/// Asymmetry
/// sum V grad W
/// h up to which a particle's surroundings are even, so that short windows remove its whole divergence and defer none
/// of it; 0.7 at a flat surface.
/// Unit: 1. Test: FreeWater.ShortWindowsFeedItNoEnergy (untried).
inline constexpr double even_surroundings = 0.05;

/// Displacement of a particle of water in soil by shifting, per
/// v
/// dt h and
/// sum V grad W
/// .
/// Unit: 1. Test: Seepage.WaterPressedIntoDrySoilKeepsItsPacking (untried).
inline constexpr double shift_by_speed_in_soil = 0.5;
/// Displacement of a particle of free water by shifting, per
/// v
/// dt h and
/// sum V grad W
/// .
/// Unit: 1. Test: none known.
inline constexpr double shift_by_speed_in_free_water = 2.0;
/// Displacement by shifting, per
/// v
/// dt h and
/// sum V grad W
/// , in soil that is full of water. It is as fast as in free water, since there is no surface that it could disturb:
/// unevenly spaced points conduct less than even ones (discharge of layered_soil 1.0 % low with 0.5, 0.7 % with 2).
/// Unit: 1. Test: layered_soil (untried).
inline constexpr double shift_by_speed_in_full_soil = 2.0;
/// Displacement by shifting per h^2 and
/// sum V grad W
/// , everywhere, also of particles that do not move.
/// Unit: 1. Test: none known.
inline constexpr double shift_by_length = 0.01;
/// Separation below which pairs are pushed apart in soil.
/// Unit: spacings. Test: none known.
inline constexpr double closest_in_soil = 0.8;
/// Separation below which pairs are pushed apart in free water.
/// Unit: spacings. Test: none known.
inline constexpr double closest_in_free_water = 0.6;
/// Fraction of the missing separation by which either particle of a pair that is too close is pushed per window:
/// together they make up half of it.
/// Unit: 1. Test: none known.
inline constexpr double push = 0.25;
/// Longest displacement by shifting in a window.
/// Unit: spacings. Test: none known.
inline constexpr double longest_shift = 0.1;
/// Separation at which approaching particles of free water collide.
/// Unit: spacings. Test: none known.
inline constexpr double collision = 0.5;

/// Residual of the repair of full soil: what is left is taken up by the next windows, whose repair is of the points as
/// they are then.
/// Unit: 1. Test: none known.
inline constexpr double repair_tolerance = 1e-2;
/// Iterations of the solve for that repair, at most.
/// Unit: iterations. Test: none known.
inline constexpr int most_repair_iterations = 200;

/// Displacement since its birth after which the packing error of a particle in soil counts in full.
/// Unit: spacings. Test: none known.
inline constexpr double repair_displacement = 0.25;
/// Displacement since its birth after which the packing error of a particle of free water counts in full: only a
/// lattice at rest has nothing to repair.
/// Unit: spacings. Test: none known.
inline constexpr double free_repair_displacement = 0.01;
/// Time in which a packing error is undone in free water: twenty times a fall through one spacing.
/// Unit: sqrt(spacing / g). Test: none known.
inline constexpr double free_repair_falls = 20.0;
/// Time in which a packing error is undone where drag is what slows the water down, n rho_w / C with the drag
/// coefficient C being its time.
/// Unit: the drag's own time. Test: none known.
inline constexpr double held_repair_times = 20.0;
/// Time in which a packing error is undone in soil: a third of the time in which a unit gradient pushes water through
/// one spacing.
/// Unit: 1. Test: Seepage.WaterPressedIntoDrySoilKeepsItsPacking (untried).
inline constexpr double pushed_repair = 0.3;
/// Least time in which a packing error is undone, anywhere: a repair in less than two windows overshoots and swings.
/// Unit: windows. Test: none known.
inline constexpr double repair_windows = 2.0;
/// Displacement of a particle in a window from which on shifting acts in full.
/// Unit: spacings. Test: none known.
inline constexpr double shifts_from = 0.02;

/// Largest strain in a window by which surface particles are moved with their surface, and whose square the source that
/// conserves volume takes into account. No reason on record.
/// Unit: 1. Test: none known.
inline constexpr double most_strain = 0.2;
/// Reduction of a particle's deficit of packing per
/// sum V grad W
/// h: where the kernel is cut off, a deficit is no error.
/// Unit: 1. Test: none known.
inline constexpr double cut_off = 5.0;

}  // namespace poretwin::fluid::motion
