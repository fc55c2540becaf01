// Chosen numbers of the length of the fluid's windows. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::fluid::steps {

/// Way of free water in a window at most.
/// Unit: spacings. Test: none known.
inline constexpr double free_courant = 0.4;
/// Longest window in which gravity waves of one spacing on a free surface are followed.
/// Unit: sqrt(spacing / g). Test: none known.
inline constexpr double wave_courant = 0.3;
/// Longest window in which particles follow the central force.
/// Unit: 1 / sqrt(force). Test: none known.
inline constexpr double central_courant = 0.02;
/// Longest window in which the viscosities of free water are stable.
/// Unit: spacings^2 / viscosity. Test: Viscosity.FlowBetweenWallsIsPoiseuilles (untried).
inline constexpr double viscous_courant = 0.2;
/// Way of seepage in a window, of a water table that falls, and of an inlet's piston, at most.
/// Unit: spacings. Test: Seepage.TheFirstWindowFollowsTheFlowThatBegins (untried).
inline constexpr double seepage_courant = 0.25;

/// Relative pressure change aimed at per window (rms, of the pressure's range).
/// Unit: 1. Test: Coupled.TerzaghiAtWindowsFromShortToLong (untried).
inline constexpr double wanted_change = 0.03;
/// Pressure changes below this share of the hydrostatic range are no reason for shorter windows.
/// Unit: 1. Test: none known.
inline constexpr double hydrostatic_share = 0.05;
/// The same of the widest range so far: water at rest has no range of its own.
/// Unit: 1. Test: none known.
inline constexpr double widest_share = 1e-3;
/// The next window over this one, at the least.
/// Unit: 1. Test: none known.
inline constexpr double shrinks_to = 0.3;
/// The same at the most.
/// Unit: 1. Test: none known.
inline constexpr double grows_to = 1.5;
/// First window of soil that responds: of the time that a wave in it takes through a spacing.
/// Unit: 1. Test: Coupled.TerzaghiAtWindowsFromShortToLong (untried).
inline constexpr double first_wave = 0.2;
/// The same where it only drains: of the time in which a spacing of it does.
/// Unit: 1. Test: none known.
inline constexpr double first_drained = 0.2;

/// By how much a change of speed may alter the way of seepage through rigid soil in a window (rms): a front a few
/// spacings deep, which slows down as it goes in, takes shorter ones than a quarter spacing.
/// Unit: spacings. Test: Seepage.AFrontIsRightFromItsFirstSpacingOn (untried).
inline constexpr double wanted_slowing = 0.0125;
/// How far water may go in a window where it leaves through a seepage face: a row that goes out takes the distance of
/// the surface with it, which is found once a window. At a quarter the discharge is 0.4 % short.
/// Unit: spacings. Test: Seepage.WaterEndsAtASeepageFace (untried).
inline constexpr double wanted_exit = 0.125;
/// How far a level behind a face may move in a window: columns are switched on and off a spacing at a time.
/// Unit: spacings. Test: CoarseSoil.WindowsEndBeforeItsLevelIsHalfASpacingOff (untried).
inline constexpr double wanted_rise = 0.5;
/// The shortest window that tables of levels, pressures and loads ask for: nothing that seeps follows faster ones.
/// Unit: sqrt(spacing / g). Test: none known.
inline constexpr double least_for_tables = 0.3;
/// Speed below which soil and the water in it are as good as at rest.
/// Unit: of what gravity gives in the window of the shortest waves. Test: none known.
inline constexpr double quasi_static = 0.01;

}  // namespace poretwin::fluid::steps
