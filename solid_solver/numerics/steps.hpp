// Chosen numbers of the solid's substeps and windows. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test's name: the test has not yet been seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::solid::steps {

/// Courant number of the substeps in the search for rest, and in soil that is coupled with water. A window consists of
/// a whole number of substeps, and the length of the windows influences how embankments fail.
/// Unit: 1. Test: Readout.CrestSettlesUnderALoad.
inline constexpr double careful = 0.8;
/// Courant number of the substeps of soil that runs without water. Measured limits of stability: 1.07 at the tips of
/// wedges cut off by walls with image particles, 1.24 at faces (docs/theory/steps.md).
/// Unit: 1. Test: none known.
inline constexpr double courant = 1.0;
/// Courant number of the substeps of soil with soft edges (docs/theory/soil.md) in 2D. The measured limit of stability
/// in disordered soil is 1.6.
/// Unit: 1. Test: GravityColumn.AWedgeOfGrainsOnARoughWallTakesLongerSteps.
inline constexpr double courant_soft_2d = 1.4;
/// Courant number of the substeps of soil with soft edges (docs/theory/soil.md) in 3D. Measured stability limit: 1.5.
/// Unit: 1. Test: none known.
inline constexpr double courant_soft_3d = 1.3;

/// Longest window in which the waves in the soil are resolved by substeps. The pore pressure is constant in a window.
/// It stops the compression of undrained soil only if the soil's shortest waves pass less than half a period in the
/// window: omega Dt < pi. Their angular frequency omega is about 1 / dt, with the substep dt. In windows of four
/// substeps the noise of a sudden load does not die out in a column of k = 1e-6 m/s.
/// Unit: substeps. Test: none known.
inline constexpr double substeps_while_moving = 2.0;

/// A long window is refused, since inertia matters, where the kinetic energy over the energy that drag and plastic flow
/// dissipate in the window exceeds this. The ratio is some thousandths in soil that consolidates, 1 in a wave.
/// Unit: 1. Test: none known.
inline constexpr double noticed = 0.05;
/// The first pass through a window is repeated where the force borne by neither phase (docs/theory/coupling.md, section
/// 3) exceeds this. With 0.003, the bound of later passes, the passes of an embankment with a yielding skin at a
/// spacing of 1 cm do not converge: such a force of 0.003 to 0.01 of the weight remains.
/// Unit: the weight. Test: none known.
inline constexpr double worth_repeating = 0.02;
/// Number of successive windows with such a force that cause no warning: where the soil's motion changes suddenly, as
/// under a load that begins, so many are usual. Only the windows after them count for the run's warning.
/// Unit: windows. Test: none known.
inline constexpr double few_held = 5.0;
/// The length of the next window is chosen such that the plastic shear strain in a window has this value; only a local
/// part of the soil may exceed it. The dilation that goes with the shear reaches the fluid one window later.
/// Unit: 1. Test: LongWindow.TheNextFollowsWhatSoilHasSheared.
inline constexpr double sheared_in_a_window = 2e-3;
/// Least ratio of the next window's length to that of the present window, where the soil's shear limits it.
/// Unit: 1. Test: LongWindow.TheNextFollowsWhatSoilHasSheared.
inline constexpr double shrinks_to = 0.3;
/// Factor by which the longest quasi-static window grows after such a window was accepted.
/// Unit: 1. Test: none known.
inline constexpr double grows_to = 1.25;
/// Ratio of the length of the next trial window to that of a window in which no equilibrium was found.
/// Unit: 1. Test: LongWindow.IsRefusedWhereSoilCannotStandAndTakenAgainOnceItIsCalm.
inline constexpr double without_equilibrium = 0.25;
/// Shortest window that the soil's shear imposes. Its unit, long_window(), is the time in which a wave crosses the soil
/// and returns.
/// Unit: long windows. Test: none known.
inline constexpr double least_by_shear = 4.0;
/// The soil shears undrained, so that none of its shear is reported as plastic, where the degree of drainage in a
/// window is below this. This degree is the window's length over the time of consolidation H^2 gamma_w / (k M).
/// Unit: 1. Test: LongWindow.TellsWhichShareOfTheShearWasPlasticAsFarAsItIsDrained.
inline constexpr double undrained = 0.2;

/// Factor by which the time grows for which moving soil must have been calm before an equilibrium is searched for
/// again. It applies each time that the soil begins to move.
/// Unit: 1. Test: none known.
inline constexpr double patience_grows = 2.0;
/// Lower limit of the calm time (patience_grows) after which an equilibrium of moving soil is searched for again.
/// Unit: long windows. Test: LongWindow.IsRefusedWhereSoilCannotStandAndTakenAgainOnceItIsCalm.
inline constexpr double least_patience = 5.0;
/// Upper limit of the calm time (patience_grows) after which an equilibrium of moving soil is searched for again.
/// Unit: long windows. Test: none known.
inline constexpr double most_patience = 100.0;

/// Length of a window of soil without water. It is this short because gauges and prescribed pore pressures are
/// evaluated between windows.
/// Unit: substeps. Test: none known.
inline constexpr double alone = 20.0;
/// Length of a window of soil without water while it sleeps.
/// Unit: substeps. Test: none known.
inline constexpr double alone_asleep = 200.0;

}  // namespace poretwin::solid::steps
