// Chosen numbers of the solid's substeps and windows. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::solid::steps {

/// Courant number of the substeps in the search for rest and of soil with water. Whole numbers of substeps make the
/// windows of an exchange, whose length decides how embankments fail.
/// Unit: 1. Test: none known.
inline constexpr double careful = 0.8;
/// The same of soil that moves. Measured limits: 1.07 at tips of wedges that walls by images cut off, 1.24 at faces
/// (docs/theory/steps.md).
/// Unit: 1. Test: GravityColumn.EdgesOfAWedgeLeaveRoom (untried).
inline constexpr double courant = 1.0;
/// The same with soft edges in 2D; limit in disordered soil 1.6.
/// Unit: 1. Test: GravityColumn.AWedgeOfGrainsOnARoughWallTakesLongerSteps (untried).
inline constexpr double courant_soft_2d = 1.4;
/// The same in 3D; limit 1.5.
/// Unit: 1. Test: none known.
inline constexpr double courant_soft_3d = 1.3;

/// The longest window in which waves in the soil are followed. The pressure is held in a window: it stops the
/// compression of undrained soil only where the shortest waves swing by less than half a period meanwhile, omega Dt <
/// pi, and these have omega dt of about 1. Windows of four substeps kept the noise of a sudden load alive for ever in a
/// column of k = 1e-6 m/s.
/// Unit: substeps. Test: Window.ConsolidatesWithAnAnalyticPartner (untried).
inline constexpr double substeps_while_moving = 2.0;

/// Kinetic energy, over what drag and plastic flow dissipate meanwhile, from which on it is missed: soil that
/// consolidates under a sudden load has some thousandths of it, a wave all of it.
/// Unit: 1. Test: LongWindow.IsRefusedWhereSoilCannotStandAndTakenAgainOnceItIsCalm (untried).
inline constexpr double noticed = 0.05;
/// Force borne by neither phase above which a window's first pass is not accepted. With 0.003, the bound of later
/// passes, an embankment with a yielding skin at 1 cm keeps 0.003 to 0.01 of it, and its passes do not converge.
/// Unit: the weight. Test: none known.
inline constexpr double worth_repeating = 0.02;
/// Windows with such a force up to which a sudden change of the soil's motion explains it, as under a load that begins.
/// Unit: windows. Test: none known.
inline constexpr double few_held = 5.0;
/// Plastic shear strain in a window by which all but a local share of the soil may go on: its dilation is water that
/// the fluid learns of in the next window only.
/// Unit: 1. Test: LongWindow.TheNextFollowsWhatSoilHasSheared (untried).
inline constexpr double sheared_in_a_window = 2e-3;
/// The next window over this one, at the least, where soil shears.
/// Unit: 1. Test: none known.
inline constexpr double shrinks_to = 0.3;
/// The same at the most.
/// Unit: 1. Test: none known.
inline constexpr double grows_to = 1.25;
/// The window that is tried instead, over one that has no equilibrium.
/// Unit: 1. Test: none known.
inline constexpr double without_equilibrium = 0.25;
/// Shortest window that shearing asks for.
/// Unit: long windows. Test: none known.
inline constexpr double least_by_shear = 4.0;
/// Time factor of drainage below which soil shears undrained: nothing of its shear counts as plastic.
/// Unit: 1. Test: LongWindow.TellsWhichShareOfTheShearWasPlasticAsFarAsItIsDrained (untried).
inline constexpr double undrained = 0.2;

/// How the time of calm grows after which rest is sought again, when none was found.
/// Unit: 1. Test: none known.
inline constexpr double patience_grows = 2.0;
/// That time at the least.
/// Unit: long windows. Test: none known.
inline constexpr double least_patience = 5.0;
/// The same at the most.
/// Unit: long windows. Test: none known.
inline constexpr double most_patience = 100.0;

/// Window of soil alone: gauges and prescribed water are seen between windows.
/// Unit: substeps. Test: none known.
inline constexpr double alone = 20.0;
/// The same while it sleeps.
/// Unit: substeps. Test: none known.
inline constexpr double alone_asleep = 200.0;

}  // namespace poretwin::solid::steps
