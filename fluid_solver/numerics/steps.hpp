// Chosen numbers of the length of the fluid's windows. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::fluid::steps {

/// Displacement of free water in a window, at most.
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
/// Displacement in a window of seeping water, of a water table that falls, and of an inlet's piston, at most.
/// Unit: spacings. Test: Seepage.TheFirstWindowFollowsTheFlowThatBegins (untried).
inline constexpr double seepage_courant = 0.25;

/// Change of the pressure per window (rms, over the pressure's range) that the length of the windows is chosen for.
/// Unit: 1. Test: Coupled.TerzaghiAtWindowsFromShortToLong (untried).
inline constexpr double wanted_change = 0.03;
/// Pressure changes are taken relative to a range that is at least this fraction of the hydrostatic one, so that small
/// changes do not shorten windows.
/// Unit: 1. Test: none known.
inline constexpr double hydrostatic_share = 0.05;
/// Pressure changes are taken relative to a range that is at least this fraction of the widest one so far: water at
/// rest has no range of its own.
/// Unit: 1. Test: none known.
inline constexpr double widest_share = 1e-3;
/// Least ratio of the next window to this one, by the change of the pressure.
/// Unit: 1. Test: none known.
inline constexpr double shrinks_to = 0.3;
/// Largest ratio of the next window to this one, by the change of the pressure.
/// Unit: 1. Test: none known.
inline constexpr double grows_to = 1.5;
/// Length of the first window beside soil that moves, over the time in which an elastic wave crosses one spacing of
/// saturated soil, dx / sqrt(M / rho_w).
/// Unit: 1. Test: Coupled.TerzaghiAtWindowsFromShortToLong (untried).
inline constexpr double first_wave = 0.2;
/// Length of the first window beside soil that moves but cannot yield, over the time in which one spacing of it drains,
/// dx^2 / c_v with the coefficient of consolidation c_v.
/// Unit: 1. Test: none known.
inline constexpr double first_drained = 0.2;

/// Change of the displacement of water that seeps through rigid soil in a window (rms), as far as its change of speed
/// causes it: a front a few spacings deep, which slows down as it goes in, needs shorter windows than a quarter
/// spacing.
/// Unit: spacings. Test: Seepage.AFrontIsRightFromItsFirstSpacingOn (untried).
inline constexpr double wanted_slowing = 0.0125;
/// Displacement of water in a window where it leaves through a seepage face, at most: a row that goes out takes the
/// distance of the surface with it, which is found once a window. At a quarter the discharge is 0.4 % short.
/// Unit: spacings. Test: Seepage.WaterEndsAtASeepageFace (untried).
inline constexpr double wanted_exit = 0.125;
/// Change of a level behind a face in a window, at most: columns are switched on and off a spacing at a time.
/// Unit: spacings. Test: CoarseSoil.WindowsEndBeforeItsLevelIsHalfASpacingOff (untried).
inline constexpr double wanted_rise = 0.5;
/// Shortest window to which tables of levels, pressures and loads limit the windows: no seepage follows faster changes.
/// Unit: sqrt(spacing / g). Test: none known.
inline constexpr double least_for_tables = 0.3;
/// Speed below which soil and the water in it count as at rest.
/// Unit: of what gravity gives in the window of the shortest waves. Test: none known.
inline constexpr double quasi_static = 0.01;

}  // namespace poretwin::fluid::steps
