// Chosen numbers of the length of the fluid's windows. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test's name: the test has not yet been seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::fluid::steps {

/// Largest displacement of free water in a window.
/// Unit: spacings. Test: none known.
inline constexpr double free_courant = 0.4;
/// Longest window in which gravity waves of one spacing on a free surface are resolved.
/// Unit: sqrt(spacing / g). Test: none known.
inline constexpr double wave_courant = 0.3;
/// Longest window in which the particles' motion under a central force is resolved. The force is given per mass and per
/// distance [1/s2].
/// Unit: 1 / sqrt(force). Test: none known.
inline constexpr double central_courant = 0.02;
/// Longest window in which the viscosities of free water are stable.
/// Unit: spacings^2 / viscosity. Test: Viscosity.FlowBetweenWallsIsPoiseuilles (untried).
inline constexpr double viscous_courant = 0.2;
/// Largest displacement in a window of seeping water, of a falling water table, and of an inlet's piston.
/// Unit: spacings. Test: Seepage.TheFirstWindowFollowsTheFlowThatBegins (untried).
inline constexpr double seepage_courant = 0.25;

/// The windows' length is chosen such that the pressure changes by this per window (rms, over the pressure's range).
/// Unit: 1. Test: Coupled.TerzaghiAtWindowsFromShortToLong (untried).
inline constexpr double wanted_change = 0.03;
/// Pressure changes are relative to a range of pressures. This range is at least this fraction of the hydrostatic
/// range, which prevents small changes from shortening the windows.
/// Unit: 1. Test: none known.
inline constexpr double hydrostatic_share = 0.05;
/// The range of pressures to which pressure changes are relative is also at least this fraction of the widest range so
/// far. In water at rest the present range is zero.
/// Unit: 1. Test: none known.
inline constexpr double widest_share = 1e-3;
/// Smallest factor by which the window length that the change of pressure allows may fall from window to window.
/// Unit: 1. Test: none known.
inline constexpr double shrinks_to = 0.3;
/// Largest factor by which the window length that the change of pressure allows may grow from window to window.
/// Unit: 1. Test: none known.
inline constexpr double grows_to = 1.5;
/// Length of the first window beside soil that moves, over the time dx / sqrt(M / rho_w) in which an elastic wave
/// crosses one spacing of saturated soil. With 0.5 the pressures of dynamic_column are 1 % less accurate.
/// Unit: 1. Test: Coupled.TerzaghiAtWindowsFromShortToLong (untried).
inline constexpr double first_wave = 0.2;
/// Shortest window that a change of the pressure can require, over the first window: 0.8 of the wave's time. In shorter
/// windows the same error of the volume balance makes more noise in the pressure, which shortens the windows again:
/// with 1 blocks that sink gain several times the energy of their fall, with 2.5 some of them do. With 10 the effective
/// stress in a layer that slides drifts by 14 % in 0.2 s (8 % with 4).
/// Unit: 1. Test: sliding_slope (untried).
inline constexpr double shortest_over_first = 4.0;
/// Length of the first window beside soil that moves but cannot yield, over the time dx^2 / c_v in which one spacing of
/// it drains, with the coefficient of consolidation c_v.
/// Unit: 1. Test: none known.
inline constexpr double first_drained = 0.2;

/// For water that seeps through rigid soil, the length of windows is chosen such that the change of the speed in a
/// window (rms) times the window's length is this value. A front a few spacings deep slows down as it advances; its
/// windows must be shorter than those in which it moves by a quarter spacing.
/// Unit: spacings. Test: Seepage.AFrontIsRightFromItsFirstSpacingOn (untried).
inline constexpr double wanted_slowing = 0.0125;
/// Largest displacement of water in a window where it leaves through a seepage face. The surface is found once per
/// window, so that a row that leaves changes its distance to the surface by its displacement. With a quarter spacing
/// the discharge is 0.4 % too small.
/// Unit: spacings. Test: Seepage.WaterEndsAtASeepageFace (untried).
inline constexpr double wanted_exit = 0.125;
/// Largest change in a window of a level behind a face: columns are switched on and off in steps of one spacing.
/// Unit: spacings. Test: CoarseSoil.WindowsEndBeforeItsLevelIsHalfASpacingOff (untried).
inline constexpr double wanted_rise = 0.5;
/// Shortest window that tables of levels, pressures and loads impose. Seepage does not follow faster changes of them.
/// Unit: sqrt(spacing / g). Test: none known.
inline constexpr double least_for_tables = 0.3;
/// Soil and the water in it count as at rest below this speed. The unit is the speed that gravity gives in the longest
/// window for gravity waves of one spacing (wave_courant).
/// Unit: speed that gravity gives in that window. Test: none known.
inline constexpr double quasi_static = 0.01;

}  // namespace poretwin::fluid::steps
