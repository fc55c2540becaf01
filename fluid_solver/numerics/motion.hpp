// Chosen numbers of the motion of water particles, of their packing and of numerical viscosity. What an entry needs:
// CONTRIBUTING.md.
// Symbols: v velocity, dt length of the window, h smoothing length, V bulk volume, W kernel, g gravity.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::fluid::motion {

/// Numerical viscosity of free water on shear. Without any, free water is slowly unstable.
/// Unit: spacings times the speed of long waves. Test: FreeWater.DisorderedTankStaysQuiet (untried).
inline constexpr double shear_viscosity = 0.01;
/// Numerical viscosity of free water on the part of the velocity that is not linear around a particle.
/// Unit: spacings times the speed of long waves. Test: FreeWater.VorticesDecayAtTheRateOfTheViscosity (untried).
inline constexpr double noise_viscosity = 0.05;
/// Numerical viscosity of free water between particles that approach each other.
/// Unit: h times the speed of approach. Test: none known.
inline constexpr double impact_viscosity = 0.5;
/// Numerical viscosity on shear in place of shear_viscosity where explicit sweeps find the pressure. Sweeps transmit
/// sound and need as much viscosity as weakly compressible SPH, alpha h c / (2 (D + 2)) with alpha of at least 0.03 and
/// c = 10 sqrt(g H) (Monaghan 1994).
/// Unit: spacings times the speed of long waves. Test: Eisph.DisorderedTankStaysQuiet (untried).
inline constexpr double sweep_viscosity = 0.05;
/// Distance up to which two particles belong to one body of water, whose depth gives the speed of its longest waves.
/// Unit: spacings. Test: Locality.ADeepPoolFarAwayLeavesFreeWaterAsItIs (untried).
inline constexpr double touching = 1.6;
/// Asymmetry |sum V grad W| h up to which a particle's surroundings count as even; at a flat surface it is 0.7. In even
/// surroundings short windows remove the whole divergence and defer none of it.
/// Unit: 1. Test: FreeWater.ShortWindowsFeedItNoEnergy (untried).
inline constexpr double even_surroundings = 0.05;

/// Displacement by shifting of a particle in soil, per |v - v_s| dt h (v_s: velocity of the soil) and per |sum V grad W|.
/// Unit: 1. Test: Seepage.WaterPressedIntoDrySoilKeepsItsPacking (untried).
inline constexpr double shift_by_speed_in_soil = 0.5;
/// Displacement by shifting of a particle of free water, per |v| dt h and per |sum V grad W|.
/// Unit: 1. Test: none known.
inline constexpr double shift_by_speed_in_free_water = 2.0;
/// Displacement by shifting per |v| dt h and per |sum V grad W| in soil that is full of water. It equals that of free
/// water, since there is no surface that it could disturb. Unevenly spaced points conduct less than even ones: with 0.5
/// the discharge of layered_soil is 1.0 % low, with 2 it is 0.7 % low.
/// Unit: 1. Test: layered_soil (untried).
inline constexpr double shift_by_speed_in_full_soil = 2.0;
/// Displacement by shifting per h^2 and per |sum V grad W|, everywhere, also of particles that do not move.
/// Unit: 1. Test: none known.
inline constexpr double shift_by_length = 0.01;
/// Separation below which pairs are pushed apart in soil.
/// Unit: spacings. Test: none known.
inline constexpr double closest_in_soil = 0.8;
/// Separation below which pairs are pushed apart in free water.
/// Unit: spacings. Test: none known.
inline constexpr double closest_in_free_water = 0.6;
/// Fraction of the missing separation by which each particle of a pair that is too close is displaced per window.
/// Together they restore half of it.
/// Unit: 1. Test: none known.
inline constexpr double push = 0.25;
/// Longest displacement by shifting in a window.
/// Unit: spacings. Test: none known.
inline constexpr double longest_shift = 0.1;
/// Separation at which approaching particles of free water collide.
/// Unit: spacings. Test: none known.
inline constexpr double collision = 0.5;

/// Residual of the repair of the packing in full soil. What remains is repaired in the next windows, from the points'
/// positions then.
/// Unit: 1. Test: none known.
inline constexpr double repair_tolerance = 1e-2;
/// Largest number of iterations in the solve for that repair.
/// Unit: iterations. Test: none known.
inline constexpr int most_repair_iterations = 200;

/// Displacement of a particle in soil from its place of birth from which on its packing error counts in full.
/// Unit: spacings. Test: none known.
inline constexpr double repair_displacement = 0.25;
/// Displacement of a particle of free water from its place of birth from which on its packing error counts in full.
/// Only a lattice at rest has nothing to repair.
/// Unit: spacings. Test: none known.
inline constexpr double free_repair_displacement = 0.01;
/// Time in which a packing error is removed in free water. A fall through one spacing takes 1.4 of the same unit.
/// Unit: sqrt(spacing / g). Test: none known.
inline constexpr double free_repair_falls = 20.0;
/// Time in which a packing error is removed where drag slows the water down. The unit is n rho_w / C with the drag
/// coefficient C.
/// Unit: the drag's own time. Test: none known.
inline constexpr double held_repair_times = 20.0;
/// Time in which a packing error is removed in soil. The unit is the time in which a unit gradient pushes water through
/// one spacing.
/// Unit: 1. Test: Seepage.WaterPressedIntoDrySoilKeepsItsPacking (untried).
inline constexpr double pushed_repair = 0.3;
/// Least time in which a packing error is removed. A repair in less than two windows overshoots and oscillates.
/// Unit: windows. Test: none known.
inline constexpr double repair_windows = 2.0;
/// Membership in the soil from which on the repair of the packing takes soil along.
/// Unit: 1. Test: none known.
inline constexpr double in_soil = 0.5;
/// Displacement of a particle in a window from which on shifting acts in full.
/// Unit: spacings. Test: none known.
inline constexpr double shifts_from = 0.02;

/// Largest strain in a window that is used to move surface particles with their surface and, squared, in the source
/// that conserves volume. The reason for the value is not on record.
/// Unit: 1. Test: none known.
inline constexpr double most_strain = 0.2;
/// Reduction of a particle's deficit of packing per |sum V grad W| h: where the kernel is cut off, a deficit is no
/// error.
/// Unit: 1. Test: none known.
inline constexpr double cut_off = 5.0;

}  // namespace poretwin::fluid::motion
