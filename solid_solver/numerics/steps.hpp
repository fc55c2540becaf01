// Chosen numbers of the solid's substeps and windows. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::solid::steps {

/// Courant number of the substeps in the search for rest and of soil with water. Whole numbers of substeps make the
/// windows of an exchange, whose length decides how embankments fail.
/// Unit: 1. Test: none known.
inline constexpr double careful = 0.8;
/// Courant number of the substeps of soil that moves by itself. Measured limits: 1.07 at tips of wedges that walls by
/// images cut off, 1.24 at faces (docs/theory/steps.md).
/// Unit: 1. Test: GravityColumn.EdgesOfAWedgeLeaveRoom (untried).
inline constexpr double courant = 1.0;
/// Courant number of the substeps of soil with soft edges (docs/theory/soil.md) in 2D; measured limit in disordered
/// soil 1.6.
/// Unit: 1. Test: GravityColumn.AWedgeOfGrainsOnARoughWallTakesLongerSteps (untried).
inline constexpr double courant_soft_2d = 1.4;
/// Courant number of the substeps of soil with soft edges in 3D; measured limit 1.5.
/// Unit: 1. Test: none known.
inline constexpr double courant_soft_3d = 1.3;

/// Longest window in which waves in the soil are followed. The pressure is constant in a window: it stops the
/// compression of undrained soil only where the shortest waves swing by less than half a period meanwhile, omega Dt <
/// pi, and these have omega dt of about 1 with the substep dt. In windows of four substeps the noise of a sudden load
/// does not die out in a column of k = 1e-6 m/s.
/// Unit: substeps. Test: Window.ConsolidatesWithAnAnalyticPartner (untried).
inline constexpr double substeps_while_moving = 2.0;

/// Kinetic energy, over what drag and plastic flow dissipate in the window, above which inertia matters and a long
/// window is refused: soil that consolidates under a sudden load has some thousandths of it, a wave all of it.
/// Unit: 1. Test: LongWindow.IsRefusedWhereSoilCannotStandAndTakenAgainOnceItIsCalm (untried).
inline constexpr double noticed = 0.05;
/// Force borne by neither phase above which a window's first pass is not accepted. With 0.003, the bound of later
/// passes, an embankment with a yielding skin at 1 cm keeps 0.003 to 0.01 of it, and its passes do not converge.
/// Unit: the weight. Test: none known.
inline constexpr double worth_repeating = 0.02;
/// Windows in a row with such a force that are not counted for the run's warning: a sudden change of the soil's motion
/// explains them, as under a load that begins.
/// Unit: windows. Test: none known.
inline constexpr double few_held = 5.0;
/// Plastic shear strain in a window that the next window is chosen for, exceeded by a local share of the soil only: the
/// dilation that goes with it is water that the fluid learns of in the next window.
/// Unit: 1. Test: LongWindow.TheNextFollowsWhatSoilHasSheared (untried).
inline constexpr double sheared_in_a_window = 2e-3;
/// Least ratio of the next window to this one, where the soil's shear limits it.
/// Unit: 1. Test: none known.
inline constexpr double shrinks_to = 0.3;
/// Growth of the longest long window after one that succeeded.
/// Unit: 1. Test: none known.
inline constexpr double grows_to = 1.25;
/// Ratio of the window that is tried next to one in which no equilibrium was found.
/// Unit: 1. Test: none known.
inline constexpr double without_equilibrium = 0.25;
/// Shortest window to which the soil's shear limits the next one.
/// Unit: long windows. Test: none known.
inline constexpr double least_by_shear = 4.0;
/// Degree of drainage within a window (window over the time of consolidation H^2 gamma_w / (k M)) below which soil
/// shears undrained, so that none of its shear is reported as plastic.
/// Unit: 1. Test: LongWindow.TellsWhichShareOfTheShearWasPlasticAsFarAsItIsDrained (untried).
inline constexpr double undrained = 0.2;

/// Growth of the time for which moving soil must have been calm before an equilibrium is looked for again, each time
/// that it begins to move.
/// Unit: 1. Test: none known.
inline constexpr double patience_grows = 2.0;
/// Least time for which moving soil must have been calm before an equilibrium is looked for again.
/// Unit: long windows. Test: none known.
inline constexpr double least_patience = 5.0;
/// Longest time for which moving soil must have been calm before an equilibrium is looked for again.
/// Unit: long windows. Test: none known.
inline constexpr double most_patience = 100.0;

/// Window of soil without water. It is that short since gauges and prescribed pore pressures are evaluated between
/// windows.
/// Unit: substeps. Test: none known.
inline constexpr double alone = 20.0;
/// Window of soil without water while it sleeps.
/// Unit: substeps. Test: none known.
inline constexpr double alone_asleep = 200.0;

}  // namespace poretwin::solid::steps
