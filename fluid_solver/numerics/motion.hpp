// Chosen numbers of the motion of water particles, of their packing and of numerical viscosity. What an entry needs:
// CONTRIBUTING.md.
// Symbols: v velocity, dt length of the window, h smoothing length, V bulk volume, W kernel, g gravity.
// (untried) behind a test's name: the test has not yet been seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::fluid::motion {

/// Numerical viscosity of free water that acts on shear. Without it, free water is slowly unstable.
/// Unit: spacings times the speed of long waves. Test: FreeWater.DisorderedTankStaysQuiet (untried).
inline constexpr double shear_viscosity = 0.01;
/// Numerical viscosity of free water that acts on the part of the velocity that is not linear around a particle.
/// Unit: spacings times the speed of long waves. Test: FreeWater.VorticesDecayAtTheRateOfTheViscosity (untried).
inline constexpr double noise_viscosity = 0.05;
/// Numerical viscosity of free water that acts between particles that approach each other.
/// Unit: h times the speed of approach. Test: none known.
inline constexpr double impact_viscosity = 0.5;
/// Numerical viscosity on shear, in place of shear_viscosity, where explicit sweeps find the pressure. Sweeps transmit
/// sound and need as much viscosity as weakly compressible SPH: alpha h c / (2 (D + 2)) with alpha of at least 0.03 and
/// c = 10 sqrt(g H), H: depth (Monaghan 1994).
/// Unit: spacings times the speed of long waves. Test: Eisph.DisorderedTankStaysQuiet (untried).
inline constexpr double sweep_viscosity = 0.05;
/// Two particles up to this distance apart belong to one body of water. Its depth gives the speed of its longest waves.
/// Unit: spacings. Test: Locality.ADeepPoolFarAwayLeavesFreeWaterAsItIs (untried).
inline constexpr double touching = 1.6;
/// A particle's surroundings count as even where their asymmetry |sum V grad W| h is at most this value; at a flat
/// surface it is 0.7. In even surroundings short windows remove the whole divergence and defer none of it.
/// Unit: 1. Test: FreeWater.ShortWindowsFeedItNoEnergy (untried).
inline constexpr double even_surroundings = 0.05;

/// Displacement by shifting of a particle in soil, per |v - v_s| dt h (v_s: soil's velocity) and per |sum V grad W|.
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
/// Each particle of a pair that is too close is displaced per window by this fraction of the missing separation.
/// Together both displacements restore half of the missing separation.
/// Unit: 1. Test: none known.
inline constexpr double push = 0.25;
/// Longest displacement by shifting in a window.
/// Unit: spacings. Test: none known.
inline constexpr double longest_shift = 0.1;
/// Separation at which approaching particles of free water collide.
/// Unit: spacings. Test: none known.
inline constexpr double collision = 0.5;

/// Residual at which the solve for the repair of the packing in full soil ends. The remaining error is repaired in the
/// next windows, from the points' positions in those windows.
/// Unit: 1. Test: none known.
inline constexpr double repair_tolerance = 1e-2;
/// Largest number of iterations in the solve for the repair of the packing.
/// Unit: iterations. Test: none known.
inline constexpr int most_repair_iterations = 200;

/// The packing error of a particle in soil counts in full beyond this displacement from the particle's birthplace.
/// Unit: spacings. Test: none known.
inline constexpr double repair_displacement = 0.25;
/// The packing error of a particle of free water counts in full beyond this displacement from the particle's
/// birthplace. Only a lattice at rest needs no repair.
/// Unit: spacings. Test: none known.
inline constexpr double free_repair_displacement = 0.01;
/// Time in which a packing error is removed in free water. A free fall through one spacing takes 1.4 of this unit.
/// Unit: sqrt(spacing / g). Test: none known.
inline constexpr double free_repair_falls = 20.0;
/// Time in which a packing error is removed where drag slows the water down. The unit is the relaxation time n rho_w /
/// C of the drag, with the drag coefficient C.
/// Unit: relaxation times of the drag. Test: none known.
inline constexpr double held_repair_times = 20.0;
/// Time in which a packing error is removed in soil. The unit is the time in which a unit gradient pushes water through
/// one spacing.
/// Unit: 1. Test: Seepage.WaterPressedIntoDrySoilKeepsItsPacking (untried).
inline constexpr double pushed_repair = 0.3;
/// Least time in which a packing error is removed. A repair in less than two windows overshoots and oscillates.
/// Unit: windows. Test: none known.
inline constexpr double repair_windows = 2.0;
/// The repair of the packing displaces soil with its water where the membership in the soil is at least this.
/// Unit: 1. Test: none known.
inline constexpr double in_soil = 0.5;
/// Shifting acts in full on a particle that moves by at least this length in a window, and less on one that moves less.
/// Unit: spacings. Test: none known.
inline constexpr double shifts_from = 0.02;

/// Upper bound of the strain in a window that is used to move surface particles with their surface. The source that
/// conserves volume uses the square of this strain. The reason for the value is not on record.
/// Unit: 1. Test: none known.
inline constexpr double most_strain = 0.2;
/// A particle's deficit of packing is reduced by this fraction per |sum V grad W| h: where the kernel is cut off at a
/// surface, a deficit is no error.
/// Unit: 1. Test: none known.
inline constexpr double cut_off = 5.0;

}  // namespace poretwin::fluid::motion
