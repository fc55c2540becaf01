// Chosen numbers of the window's pressure solve and of explicit sweeps. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::fluid::pressure {

/// Relative residual of the solve where no water is in soil: a dam break's front and energy are the same as with 1e-4.
/// Unit: 1. Test: FreeWater.DamBreakKeepsItsEnergy (untried).
inline constexpr double free_water_tolerance = 1e-3;
/// Smallest relative residual of the solve between soils of different conductivity. The residual is relative to what
/// drives the flow, which the most permeable soil sets; what flows is set by the least permeable one, and the residual
/// left there moves water of the permeable one. A smaller one is lost in rounding.
/// Unit: 1. Test: Seepage.SoilsInSeriesAndSideBySide (untried).
inline constexpr double tightest_tolerance = 1e-11;
/// Relative residual of the solve for the pressures that a run starts from. No reason on record.
/// Unit: 1. Test: none known.
inline constexpr double initial_tolerance = 1e-8;

/// Residual of a solve with a responding skeleton, over the window's pressure change.
/// Unit: 1. Test: Coupled.TerzaghiInNearlyTightSoil (untried).
inline constexpr double response_tolerance = 1e-2;
/// Residual of the solve for the skeleton's velocity, over the change of that velocity or over the velocity that drag
/// alone would give the skeleton, whichever is more. 1e-2 would be noticeable, as pressure in nearly tight soil at rest
/// and as momentum (docs/notebook/fluid.md).
/// Unit: 1. Test: Coupled.DragRelaxesAtItsRateAndKeepsMomentum (untried).
inline constexpr double skeleton_tolerance = 1e-3;
/// Residual of the two fields' blocks where they precondition the iteration for both together.
/// Unit: 1. Test: none known (iterations, not results).
inline constexpr double preconditioner_tolerance = 1e-1;
/// Least density of a skeleton that responds, over the water's.
/// Unit: 1. Test: none known.
inline constexpr double least_responding = 1e-6;

/// A window is solved again when the drag's tangent misses the law by more than this share of inertia and drag (rms).
/// Unit: 1. Test: Coupled.QuadraticDragFollowsItsClosedFormAndKeepsMomentum (untried).
inline constexpr double drag_tolerance = 0.02;
/// Solves of a window for its drag, at most. No reason on record.
/// Unit: solves. Test: none known.
inline constexpr int most_drag_rounds = 10;

/// Width of an aggregate of the skeleton's coarse space: 4 to 6 take the fewest CPU seconds, in embankment_seepage and
/// in rockfill_dam.
/// Unit: spacings. Test: none known (time, not results).
inline constexpr double aggregate_width = 5.0;
/// Iterations for the pressure with the diagonal preconditioner: a solve that takes no more is faster without a coarse
/// space.
/// Unit: iterations. Test: none known (time, not results).
inline constexpr int iterations_without_aggregates = 4;
/// Iterations of conjugate gradients with aggregates after which multigrid takes over: so many take as long as the
/// whole solve by multigrid, setup included, from 10,000 particles on (55 to 80 measured, multigrid_timing.cpp).
/// Unit: iterations. Test: FreeWater.ItsSolvesTakeFewIterationsAtAnySize (untried).
inline constexpr int patience = 70;
/// A solve that takes multigrid no more cycles than this begins with the diagonal preconditioner next time.
/// Unit: cycles. Test: none known (time, not results).
inline constexpr int few_cycles = 2;
/// Added to the diagonal of aggregates, over it, where nothing prescribes a mean pressure and the matrix is singular.
/// Unit: 1. Test: none known.
inline constexpr double regularisation = 1e-8;

/// Rounds in which the set of cavitating particles is found, at most.
/// Unit: rounds. Test: none known.
inline constexpr int most_cavitation_rounds = 30;
/// By which fraction of the cavitation pressure water must lie below it to join the cavitating set, and voids must
/// still open to stay in it: above what the iteration of a solve leaves.
/// Unit: 1. Test: none known.
inline constexpr double cavitation_tolerance = 1e-4;
/// Weight of a row that fixes cavitating water at its pressure, over the row's diagonal.
/// Unit: 1. Test: none known.
inline constexpr double cavitating_weight = 1e6;
/// Weight of a row whose pressure is prescribed, over the row's diagonal.
/// Unit: 1. Test: none known.
inline constexpr double pinned_weight = 1e3;

/// Mean of a moment's eigenvalues up to which a particle's neighbours are too few to even out their directions.
/// Unit: 1. Test: none known.
inline constexpr double even_from = 0.75;
/// By how much pairs are weakened or strengthened at most where directions or borders are evened out: they keep a tenth
/// at least.
/// Unit: 1. Test: Seepage.SoilsSideBySideDoNotHoldEachOther (untried).
inline constexpr double most_stretched = 0.9;
/// Rounds in which pairs along a border are strengthened: two rows on either side have a share of each other's.
/// Unit: rounds. Test: none known.
inline constexpr int border_rounds = 4;

/// Relaxation of a sweep. The largest eigenvalue of a graph Laplacian over its diagonal is 2 at worst (two particles
/// alone with each other), where an unrelaxed sweep is at the limit of its stability; 1.2 on a lattice.
/// Unit: 1. Test: Eisph.SweepsTendToTheSolution (untried).
inline constexpr double sweep_relaxation = 0.8;
/// Share of its volume by which free water may seem compressed at the pressures at hand: 1 %, as in weakly compressible
/// SPH (Monaghan 1994: a speed of sound ten times the flow's). In a dam break 3 % costs the front 2 cm of 1.9 m.
/// Unit: 1. Test: Eisph.WindowsFollowFromTheCompressionOfASweep (untried).
inline constexpr double free_compression = 0.01;
/// Share of its volume by which water in soil may seem compressed at the pressures at hand. There it only delays: 10 %
/// shifts a wetting front by 0.15 %.
/// Unit: 1. Test: Eisph.WindowsFollowFromTheCompressionOfASweep (untried).
inline constexpr double soil_compression = 0.1;

}  // namespace poretwin::fluid::pressure
